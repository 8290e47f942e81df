"""Cables painted over or added: skins of any kind, what grows over them, and their shadows."""

from __future__ import annotations

import math

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from map_pictures.beside_cables import SEAMED, TRENCHED, add_seams, add_trench
from map_pictures.grounds import GROUNDS, view_in_perspective, waves
from map_pictures.surface import Surface, logistic, random_pose, roughen, surface

PAINTED = 0.4
"""Share of the cables that are painted over with a skin that no world has."""

ADDED = 0.3
"""Share of the pictures without a cable that are given one: the same ground with and without."""

LAMPLIT = 0.35
"""Share of the painted cables that a lamp at one side lights, so that the other lies in shadow."""

SHADED, CRISP, SPANNING = 0.5, 0.6, 0.4
"""Share of the cables that cast a shadow to one side, of those shadows that have an end, and of
these that lie apart from the cable, as below a free span."""

OVERGROWN, FINNED = 0.06, 0.2
"""Shares of the painted cables that are grown over with what lies beside them, and, of the others,
of those with fins wound around them."""

BURIED = 0.45
"""Share of the painted cables of which the ground covers a part."""

PLAIN = 0.4
"""Share of the pictures without a cable whose ground is made plain before."""


def with_random_cable(
    levels: Image, pose: FloatArray, may_be_shaded: bool, rng: np.random.Generator
) -> tuple[Image, FloatArray]:
    """Return a picture, and its pose, with a cable painted over, added or beside its shadow."""
    has_cable = not np.isnan(pose).any()
    if rng.random() < (PAINTED if has_cable else ADDED):
        pose = pose if has_cable else random_pose(rng)
        paint = _overgrow_cable if rng.random() < OVERGROWN else _paint_cable
        levels, has_cable = paint(levels, pose, may_be_shaded, rng), True
    elif not has_cable and rng.random() < PLAIN:
        levels = levels.mean() + np.float32(rng.random()) * (levels - levels.mean())
    elif has_cable and may_be_shaded and rng.random() < SHADED:
        at = surface(pose, levels.shape)
        levels = _add_shadow(levels, at, rng.choice((-1.0, 1.0)), rng)
    if has_cable and may_be_shaded and rng.random() < SEAMED:
        levels = add_seams(levels, surface(pose, levels.shape), 0.3, rng)
    if has_cable and rng.random() < TRENCHED:
        levels = add_trench(levels, surface(pose, levels.shape), rng)
    return levels, pose


def _paint_cable(
    levels: Image, pose: FloatArray, may_be_shaded: bool, rng: np.random.Generator
) -> Image:
    """Return a picture whose cable has a skin of any kind: shaded, striped, wound, patched.

    Some cast a shadow to one side, if they may; of one in three the ground covers a part.
    """
    at, deviation = surface(pose, levels.shape), float(levels.std()) + 3.0
    fins = _fins(at, rng) if rng.random() < FINNED else np.zeros_like(at.across)
    skin = _bands(at, rng) + _shading(at, rng) + _shade_relief(fins, rng)
    grain = view_in_perspective(GROUNDS[rng.integers(len(GROUNDS))](rng), levels.shape, rng)
    skin += np.float32(0.6 * rng.random() ** 2 / max(float(grain.std()), 0.3)) * grain
    contrast = np.float32(math.exp(rng.uniform(-1.0, 1.2)) * rng.choice((-1.0, 1.0)))
    outside = roughen(at, rng) - np.float32(at.width * rng.uniform(0.0, 0.12)) * fins
    share = logistic(-outside / np.float32(rng.uniform(0.3, 1.5)))
    if rng.random() < BURIED:
        share *= shown_share(at, rng)
    side = rng.choice((-1.0, 1.0))
    if may_be_shaded and rng.random() < SHADED:
        levels = _add_shadow(levels, at, side, rng)
    beside = levels[(at.outside > 0.0) & (at.outside < max(at.width, 10.0))]
    around = float(beside.mean()) if len(beside) else float(levels.mean())
    painted = around + np.float32(deviation) * (contrast + np.float32(rng.uniform(0.3, 1.5)) * skin)
    if may_be_shaded and rng.random() < LAMPLIT:
        levels, painted = _light_from_side(levels, painted, at, side, rng)
    mixed: Image = levels + share.astype(np.float32) * (painted - levels)
    return mixed


def shown_share(at: Surface, rng: np.random.Generator) -> Image:
    """Return the share of each pixel of a cable that the ground does not cover.

    It covers patches, whole stretches, or the cable from one side on, and leaves a quarter or more
    of it.
    """
    cover = view_in_perspective(waves(rng), at.across.shape, rng)
    cover /= np.float32(max(float(cover.std()), 0.3))
    lying = rng.random()
    if lying < 0.3:
        length = np.float32(at.width * 0.5 * 12.0 ** rng.random() + 10.0)
        phase = 2.0 * math.pi * (at.along / length + rng.random())
        cover = np.float32(0.4) * cover + np.float32(2.0) * np.sin(phase)
    elif lying < 0.6:
        cover = np.float32(0.4) * cover + np.float32(rng.choice((-3.0, 3.0))) * at.across
    on_cable = cover[at.outside < 0.0]
    if len(on_cable) == 0:
        return np.ones_like(cover)
    shown = (cover < np.quantile(on_cable, rng.uniform(0.25, 1.0))).astype(np.float32)
    return cv2.GaussianBlur(shown, (0, 0), rng.uniform(0.3, 3.0))


def _overgrow_cable(
    levels: Image, pose: FloatArray, may_be_shaded: bool, rng: np.random.Generator
) -> Image:
    """Return a picture with a cable that is grown over with what lies beside it.

    The light on a round body shows it, and the seams along its flanks, if there may be any.
    """
    at, deviation = surface(pose, levels.shape), float(levels.std()) + 3.0
    _, angle, width, _ = pose
    apart = width * rng.uniform(1.2, 2.0) * rng.choice((-1.0, 1.0))
    moved = np.array([[1.0, 0.0, apart * math.cos(angle)], [0.0, 1.0, -apart * math.sin(angle)]])
    beside = cv2.warpAffine(levels, moved, levels.shape[::-1], borderMode=cv2.BORDER_REFLECT)
    skin = np.float32(0.3 * rng.normal()) + np.float32(rng.uniform(0.3, 1.5)) * _shading(at, rng)
    grown = beside + np.float32(deviation) * skin
    share = logistic(-roughen(at, rng) / np.float32(rng.uniform(0.5, 3.0)))
    mixed = levels + share.astype(np.float32) * (grown - levels)
    # A single seam on ground that goes on behind it would be a thin cable.
    return add_seams(mixed, at, 1.0, rng) if may_be_shaded else mixed


def _add_shadow(levels: Image, at: Surface, side: float, rng: np.random.Generator) -> Image:
    """Return ground on which a cable casts a shadow to one side.

    It fades out, or it has an end; then the ground in it shows through, and it may lie apart from
    the cable, as below a free span that rises along the way.
    """
    outside = np.maximum(at.outside, 0.0)
    on_its_side = side * at.across > 0.0
    if rng.random() >= CRISP:
        fading = np.exp(-outside / np.float32(at.width * rng.uniform(0.1, 0.8))) * on_its_side
        depth = np.float32(1.5 * rng.random() * (float(levels.std()) + 3.0))
        return np.asarray(levels - depth * fading, np.float32)
    begin = np.zeros_like(outside)
    if rng.random() < SPANNING:
        rise = rng.uniform(-0.3, 0.3) * at.along
        begin = np.maximum(at.width * rng.uniform(0.0, 2.0) + rise, 0.0).astype(np.float32)
    end = begin + np.float32(at.width * rng.uniform(0.1, 1.3))
    soft = np.float32(rng.uniform(0.4, 1.0 + 0.1 * at.width))
    # Where it begins at the cable there is no ramp, but the cable's border.
    begun = np.where(begin > 0.0, logistic((outside - begin) / soft), 1.0)
    within = begun * logistic((end - outside) / soft) * (on_its_side & (at.outside > 0.0))
    return np.asarray(levels * (1.0 - rng.uniform(0.1, 0.9) * within), np.float32)


def _light_from_side(
    levels: Image, painted: Image, at: Surface, side: float, rng: np.random.Generator
) -> tuple[Image, Image]:
    """Return ground and cable under a lamp at one side: the other lies in the body's shadow.

    Both are as dark there, so that no border is left between them.
    """
    from_above = math.radians(rng.uniform(20.0, 85.0))
    slope = np.arcsin(np.clip(at.across, -1.0, 1.0))
    body = np.maximum(np.cos(slope + side * from_above), 0.0)
    dark = np.float32(rng.uniform(0.1, 0.6))
    soft = np.float32(rng.uniform(1.0, 1.0 + 0.15 * at.width))
    end = np.float32(at.width * 0.15 * (4.0 / 0.15) ** rng.random())
    behind = (side * at.across > 0.0) * logistic((end - at.outside) / soft)
    return (
        levels * (1.0 - (1.0 - dark) * behind).astype(np.float32),
        painted * (dark + (1.0 - dark) * body).astype(np.float32),
    )


def _shading(at: Surface, rng: np.random.Generator) -> Image:
    """Return the shading of a round body under some light, of any kind but smooth across it."""
    slope, bulge, rim = rng.normal(0.0, 0.5, 3)
    depth = np.sqrt(np.maximum(1.0 - at.across**2, 0.0))
    shading = slope * at.across + bulge * depth + rim * (np.abs(at.across) > rng.uniform(0.5, 1.0))
    return np.asarray(shading, np.float32)


def _bands(at: Surface, rng: np.random.Generator) -> Image:
    """Return bands around a cable, straight or wound, none to two kinds of them."""
    found = np.zeros_like(at.across)
    turn = np.arcsin(np.clip(at.across, -1.0, 1.0)) / math.pi
    for _ in range(rng.integers(0, 3)):
        period = max(at.width * 0.1 * 80.0 ** rng.random(), 4.0)
        wound = rng.uniform(-2.0, 2.0) if rng.random() < 0.5 else 0.0
        phase = (at.along / np.float32(period) + np.float32(wound) * turn + rng.random()) % 1.0
        found += np.float32(rng.normal()) * (phase < rng.uniform(0.1, 0.9))
    return cv2.GaussianBlur(found, (0, 0), rng.uniform(0.5, 1.5))


def _fins(at: Surface, rng: np.random.Generator) -> Image:
    """Return the heights, 0 to 1, of fins wound around a cable, as strakes are.

    Beside the cable they go on as at its borders, beyond which they stick out.
    """
    turn = np.arcsin(np.clip(at.across, -1.0, 1.0)) / np.float32(math.pi)
    period, advance = at.width * 4.0 ** rng.uniform(-0.2, 1.0), at.width * rng.uniform(0.5, 3.5)
    along = at.along + np.float32(advance * rng.choice((-1.0, 1.0))) * turn
    phase = (along / np.float32(period) + rng.random()) % 1.0 - 0.5
    heights: Image = np.exp(-((phase / np.float32(rng.uniform(0.03, 0.12))) ** 2))
    return heights


def _shade_relief(heights: Image, rng: np.random.Generator) -> Image:
    """Return the shading of heights, 0 to 1, lit from one side and of another grey level."""
    slope = np.gradient(cv2.GaussianBlur(heights, (0, 0), 1.0))[int(rng.integers(2))]
    lit = np.float32(rng.normal()) * slope / np.float32(max(float(np.abs(slope).max()), 0.05))
    return np.asarray(lit + np.float32(rng.normal()) * heights, np.float32)
