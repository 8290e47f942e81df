"""Pictures to train on, changed as other dives would be, and their maps with them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from map_pictures.beside_cables import (
    banked,
    covered,
    littered,
    rippled,
    scarred,
    twinned,
    visited,
)
from map_pictures.camera import bent, recorded
from map_pictures.light import barred, dappled, lit, pooled, snowed, veiled
from map_pictures.skins import with_any_skin
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
    bent : float
        Share of the pictures that are bent, and their maps with them.
    of_light : tuple of (float, View)
        Light and shade.
    """

    of_ground: tuple[tuple[float, Ground], ...]
    in_front: tuple[tuple[float, View], ...]
    bent: float
    of_light: tuple[tuple[float, View], ...]


OF_FRAMES = Changes(
    of_ground=((0.3, rippled), (0.5, covered), (0.35, banked), (0.15, scarred), (0.3, littered)),
    in_front=((0.2, visited), (0.3, snowed)),
    bent=0.5,
    of_light=((0.3, lit), (0.2, dappled), (0.3, pooled), (0.3, veiled), (0.15, barred)),
)

OF_INVERTED_FRAMES = replace(
    OF_FRAMES,
    of_ground=tuple(each for each in OF_FRAMES.of_ground if littered not in each),
    of_light=tuple(each for each in OF_FRAMES.of_light if barred not in each),
)
"""Without plates and the vehicle's frame, which throw shadows."""

OF_SCENES = Changes(
    of_ground=((0.1, rippled), (0.15, covered), (0.25, banked)),
    in_front=((0.1, visited), (0.3, snowed)),
    bent=0.5,
    of_light=((0.15, lit), (0.1, dappled), (0.15, pooled), (0.2, veiled), (0.12, barred)),
)
"""Fewer: what is added to a scene has no part in its shadows."""


def augmented(image: Image, pose: FloatArray, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return levels float32 (H, W) and the true map, changed as other dives would be."""
    is_inverted = rng.random() < INVERTED
    levels, pose = with_any_skin(image.astype(np.float32), pose, not is_inverted, rng)
    cells = true_map(pose)
    if not np.isnan(pose).any() and rng.random() < TWINNED:
        levels, cells = twinned(levels, cells, pose, rng)
    changes = OF_INVERTED_FRAMES if is_inverted else OF_FRAMES
    levels, cells = _changed(levels, cells, changes, rng)
    return recorded(255.0 - levels if is_inverted else levels, rng), cells


def augmented_scene(image: Image, cells: Image, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return levels float32 (H, W) and the map of a scene, changed but for its shadows."""
    levels, shares = image.astype(np.float32), cells.astype(np.float32) / np.float32(255.0)
    levels, shares = _changed(levels, shares, OF_SCENES, rng)
    return recorded(levels, rng), shares


def _changed(
    levels: Image, cells: Image, changes: Changes, rng: np.random.Generator
) -> tuple[Image, Image]:
    """Return a picture and its map with some of the changes, mirrored or not."""
    for share, change in changes.of_ground:
        if rng.random() < share:
            levels = change(levels, cells, rng)
    levels = _viewed(levels, changes.in_front, rng)
    if rng.random() < changes.bent:
        levels, cells = bent(levels, cells, rng)
    levels = _viewed(levels, changes.of_light, rng)
    return _mirrored(levels, cells, rng)


def _viewed(
    levels: Image, changes: tuple[tuple[float, View], ...], rng: np.random.Generator
) -> Image:
    """Return a picture with some changes of what lies before it, or of its light."""
    for share, change in changes:
        if rng.random() < share:
            levels = change(levels, rng)
    return levels


def _mirrored(levels: Image, cells: Image, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return a picture and its map, mirrored along none, one or both of their sides."""
    for axis in range(2):
        if rng.random() < 0.5:
            levels, cells = np.flip(levels, axis), np.flip(cells, axis)
    return levels, np.ascontiguousarray(cells)
