"""Pictures to train on, changed as other dives would be, and their maps with them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from map_pictures.beside_cables import banked, covered, littered, rippled, twinned, visited
from map_pictures.camera import bent, recorded
from map_pictures.light import dappled, lit, pooled, snowed, veiled
from map_pictures.skins import with_any_skin
from map_pictures.surface import true_map

INVERTED = 0.3
"""Share of the pictures that are inverted. They are given no shadow: a network that sees bright
shadows as often as dark ones cannot tell them from what casts them."""

TWINNED = 0.3
"""Share of the cables beside which another one lies, of the same look: what is between the two is
no cable. Where there was none, the network took two cables and what is between for a wide one."""


@dataclass(frozen=True, slots=True)
class Changes:
    """Shares of the pictures that are changed, in this order.

    Attributes
    ----------
    rippled, covered : float
        Crossed by ripples; other ground is added.
    banked : float
        Other ground lies along one side of the cable, or along both.
    littered, visited : float
        Plates and blocks lie on the bottom, with their shadows; animals and a slack rope lie there
        and on the cable.
    snowed, bent, lit : float
        Behind particles; bent; lit by other lamps.
    dappled : float
        Under the net of light that waves make.
    pooled, veiled : float
        With pools of light or shade; with soft bands and steps of it.
    """

    rippled: float
    covered: float
    banked: float
    littered: float
    visited: float
    snowed: float
    bent: float
    lit: float
    dappled: float
    pooled: float
    veiled: float


OF_FRAMES = Changes(
    rippled=0.3,
    covered=0.5,
    banked=0.35,
    littered=0.3,
    visited=0.2,
    snowed=0.3,
    bent=0.5,
    lit=0.3,
    dappled=0.2,
    pooled=0.3,
    veiled=0.3,
)

OF_SCENES = Changes(
    rippled=0.1,
    covered=0.15,
    banked=0.25,
    littered=0.0,
    visited=0.1,
    snowed=0.3,
    bent=0.5,
    lit=0.15,
    dappled=0.1,
    pooled=0.15,
    veiled=0.2,
)
"""Fewer: what is added to a scene has no part in its shadows."""


def augmented(image: Image, pose: FloatArray, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return levels float32 (H, W) and the true map, changed as other dives would be."""
    is_inverted = rng.random() < INVERTED
    levels, pose = with_any_skin(image.astype(np.float32), pose, not is_inverted, rng)
    cells = true_map(pose)
    if not np.isnan(pose).any() and rng.random() < TWINNED:
        levels, cells = twinned(levels, cells, pose, rng)
    changes = replace(OF_FRAMES, littered=0.0) if is_inverted else OF_FRAMES
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
    if rng.random() < changes.rippled:
        levels = rippled(levels, cells, rng)
    if rng.random() < changes.covered:
        levels = covered(levels, cells, rng)
    if rng.random() < changes.banked:
        levels = banked(levels, cells, rng)
    if changes.littered and rng.random() < changes.littered:
        levels = littered(levels, cells, rng)
    if rng.random() < changes.visited:
        levels = visited(levels, rng)
    if rng.random() < changes.snowed:
        levels = snowed(levels, rng)
    if rng.random() < changes.bent:
        levels, cells = bent(levels, cells, rng)
    if rng.random() < changes.lit:
        levels = lit(levels, rng)
    if rng.random() < changes.dappled:
        levels = dappled(levels, rng)
    if rng.random() < changes.pooled:
        levels = pooled(levels, rng)
    if rng.random() < changes.veiled:
        levels = veiled(levels, rng)
    return _mirrored(levels, cells, rng)


def _mirrored(levels: Image, cells: Image, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return a picture and its map, mirrored along none, one or both of their sides."""
    for axis in range(2):
        if rng.random() < 0.5:
            levels, cells = np.flip(levels, axis), np.flip(cells, axis)
    return levels, np.ascontiguousarray(cells)
