"""Pictures to train on, changed as other dives would be, and their maps with them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from map_pictures.beside_cables import (
    add_animals_and_rope,
    add_banks,
    add_debris,
    add_grooves,
    add_other_ground,
    add_parallel_cable,
    add_ripples,
)
from map_pictures.camera import record_by_camera, warp
from map_pictures.light import (
    add_caustics,
    add_frame_shadows,
    add_light_bands,
    add_light_pools,
    add_marine_snow,
    add_uneven_light,
)
from map_pictures.skins import with_random_cable
from map_pictures.surface import true_map

INVERTED = 0.3
"""Share of the pictures that are inverted. They are given no shadow: a network that sees bright
shadows as often as dark ones cannot tell them from what casts them."""

TWINNED = 0.3
"""Share of the cables beside which another one lies, of the same look: what is between the two is
no cable. Where there was none, the network took two cables and what is between for a wide one."""


Ground = Callable[[Image, Image, np.random.Generator], Image]
"""Changes levels (H, W) whose cable covers shares of the cells (H / 4, W / 4)."""

View = Callable[[Image, np.random.Generator], Image]
"""Changes levels (H, W), ground and cable alike."""


@dataclass(frozen=True, slots=True)
class Changes:
    """Changes in their order, each with the share of the pictures that it is made to.

    Attributes
    ----------
    of_ground : tuple of (float, Ground)
        What lies on the ground, or is cut into it, and in part on the cable.
    in_front : tuple of (float, View)
        Animals, a slack rope and particles before all else.
    warped : float
        Share of the pictures that are warped, and their maps with them.
    of_light : tuple of (float, View)
        Light and shade.
    """

    of_ground: tuple[tuple[float, Ground], ...]
    in_front: tuple[tuple[float, View], ...]
    warped: float
    of_light: tuple[tuple[float, View], ...]


OF_FRAMES = Changes(
    of_ground=(
        (0.3, add_ripples),
        (0.5, add_other_ground),
        (0.35, add_banks),
        (0.15, add_grooves),
        (0.3, add_debris),
    ),
    in_front=((0.2, add_animals_and_rope), (0.3, add_marine_snow)),
    warped=0.5,
    of_light=(
        (0.3, add_uneven_light),
        (0.2, add_caustics),
        (0.3, add_light_pools),
        (0.3, add_light_bands),
        (0.15, add_frame_shadows),
    ),
)

OF_INVERTED_FRAMES = replace(
    OF_FRAMES,
    of_ground=tuple(each for each in OF_FRAMES.of_ground if add_debris not in each),
    of_light=tuple(each for each in OF_FRAMES.of_light if add_frame_shadows not in each),
)
"""Without plates and the vehicle's frame, which throw shadows."""

OF_SCENES = Changes(
    of_ground=((0.1, add_ripples), (0.15, add_other_ground), (0.25, add_banks)),
    in_front=((0.1, add_animals_and_rope), (0.3, add_marine_snow)),
    warped=0.5,
    of_light=(
        (0.15, add_uneven_light),
        (0.1, add_caustics),
        (0.15, add_light_pools),
        (0.2, add_light_bands),
        (0.12, add_frame_shadows),
    ),
)
"""Fewer: what is added to a scene has no part in its shadows."""


def augmented(image: Image, pose: FloatArray, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return levels float32 (H, W) and the true map, changed as other dives would be."""
    is_inverted = rng.random() < INVERTED
    levels, pose = with_random_cable(image.astype(np.float32), pose, not is_inverted, rng)
    cells = true_map(pose)
    if not np.isnan(pose).any() and rng.random() < TWINNED:
        levels, cells = add_parallel_cable(levels, cells, pose, rng)
    changes = OF_INVERTED_FRAMES if is_inverted else OF_FRAMES
    levels, cells = _with_changes(levels, cells, changes, rng)
    return record_by_camera(255.0 - levels if is_inverted else levels, rng), cells


def augmented_scene(image: Image, cells: Image, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return levels float32 (H, W) and the map of a scene, changed but for its shadows."""
    levels, shares = image.astype(np.float32), cells.astype(np.float32) / np.float32(255.0)
    levels, shares = _with_changes(levels, shares, OF_SCENES, rng)
    return record_by_camera(levels, rng), shares


def _with_changes(
    levels: Image, cells: Image, changes: Changes, rng: np.random.Generator
) -> tuple[Image, Image]:
    """Return a picture and its map with some of the changes, mirrored or not."""
    for share, change in changes.of_ground:
        if rng.random() < share:
            levels = change(levels, cells, rng)
    levels = _with_chosen(levels, changes.in_front, rng)
    if rng.random() < changes.warped:
        levels, cells = warp(levels, cells, rng)
    levels = _with_chosen(levels, changes.of_light, rng)
    return _flip_randomly(levels, cells, rng)


def _with_chosen(
    levels: Image, changes: tuple[tuple[float, View], ...], rng: np.random.Generator
) -> Image:
    """Return a picture with some changes of what lies before it, or of its light."""
    for share, change in changes:
        if rng.random() < share:
            levels = change(levels, rng)
    return levels


def _flip_randomly(levels: Image, cells: Image, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return a picture and its map, mirrored along none, one or both of their sides."""
    for axis in range(2):
        if rng.random() < 0.5:
            levels, cells = np.flip(levels, axis), np.flip(cells, axis)
    return levels, np.ascontiguousarray(cells)
