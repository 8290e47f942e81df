"""Straight and bright objects on the bottom that are not the cable.

The splits have different kinds: ropes, furrows and pairs of lines to tune on; tracks, rocks and
trenches to report on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.simulation.rendering.texture import smooth_step
from cable_tracker.simulation.worlds.catalogue import Split

SPACING = 260.0
"""Length of one view along the course [texels of the bottom]."""


@dataclass(frozen=True, slots=True)
class ClutterObject:
    """Something on the bottom.

    Attributes
    ----------
    kind : str
        Profile of the object: a key of `PROFILES`.
    x, y : float
        Centre [texels].
    angle : float
        Angle of the long axis from the y axis [rad].
    half_width, half_length : float
        [texels].
    strength : float
        Step of its tone [standard deviations of the bottom]; negative: dark.
    """

    kind: str
    x: float
    y: float
    angle: float
    half_width: float
    half_length: float
    strength: float


def _band(across: Image, half_width: float) -> Image:
    return np.clip(half_width - np.abs(across) + np.float32(0.5), 0.0, 1.0)


def _rope(across: Image, along: Image, half_width: float) -> Image:
    turns = 0.8 + 0.2 * np.sin((along + across) * np.float32(2.0 / half_width))
    return np.asarray(_band(across, half_width) * turns)


def _furrow(across: Image, along: Image, half_width: float) -> Image:
    u = across / np.float32(half_width)
    return np.asarray(-u * np.exp(0.5 - 0.5 * u * u))


def _pair(across: Image, along: Image, half_width: float) -> Image:
    line = max(0.12 * half_width, 1.5)
    return _band(across - half_width, line) + _band(across + half_width, line)


def _track(across: Image, along: Image, half_width: float) -> Image:
    tread = np.where(np.mod(along, np.float32(half_width)) < 0.5 * half_width, 1.0, 0.3)
    return np.asarray(_band(across, half_width) * tread, np.float32)


def _rock(across: Image, along: Image, half_width: float) -> Image:
    bearing = np.arctan2(across, along)
    outline = half_width * (1 + 0.2 * np.sin(3 * bearing + 1.0) + 0.1 * np.sin(7 * bearing))
    distance = np.hypot(across, along)
    body = np.clip(outline - distance + 0.5, 0.0, 1.0)
    shadow = np.clip(1.3 * outline - np.hypot(across - 0.4 * half_width, along), 0.0, 1.0)
    return np.asarray(body - 0.7 * shadow * (1 - body))


def _trench(across: Image, along: Image, half_width: float) -> Image:
    u = across / np.float32(half_width)
    walls = np.exp(-(((u - 0.85) / 0.2) ** 2)) - np.exp(-(((u + 0.85) / 0.2) ** 2))
    return np.asarray(walls - 0.5 * _band(across, half_width))


PROFILES: dict[str, Callable[[Image, Image, float], Image]] = {
    "rope": _rope,
    "furrow": _furrow,
    "pair": _pair,
    "track": _track,
    "rock": _rock,
    "trench": _trench,
}
"""Profiles of clutter across and along it, by kind."""

LINES = {Split.TUNE: ("rope", "furrow"), Split.REPORT: ("track", "rock")}
PAIRS = {Split.TUNE: ("pair",), Split.REPORT: ("trench",)}


def random_clutter(
    split: Split,
    extent: tuple[float, float],
    lines: float,
    pairs: float,
    rng: np.random.Generator,
) -> tuple[ClutterObject, ...]:
    """Draw objects over an extent of the course.

    Parameters
    ----------
    split : Split
        Determines the kinds of objects.
    extent : (float, float)
        First and last y [texels].
    lines, pairs : float
        Mean number of single and double lines in a view.
    """
    views = (extent[1] - extent[0]) / SPACING
    counts = rng.poisson(lines * views), rng.poisson(pairs * views)
    kinds = (LINES[split],) * int(counts[0]) + (PAIRS[split],) * int(counts[1])
    return tuple(_random_object(each, extent, rng) for each in kinds)


def _random_object(
    kinds: tuple[str, ...], extent: tuple[float, float], rng: np.random.Generator
) -> ClutterObject:
    kind = kinds[int(rng.integers(len(kinds)))]
    doubled = kind in ("pair", "trench")
    widest = 35.0 if doubled else 6.0
    narrowest = 6.0 if doubled else 1.5
    half_width = float(np.exp(rng.uniform(np.log(narrowest), np.log(widest))))
    half_length = float(rng.uniform(60.0, 260.0))
    if kind == "rock":
        half_width = half_length = float(rng.uniform(6.0, 28.0))
    # A trench is darker than the ground; bright between its walls it would be a cable.
    sign = 1.0 if kind == "trench" else float(rng.choice((-1.0, 1.0)))
    return ClutterObject(
        kind,
        float(rng.uniform(-170.0, 170.0)),
        float(rng.uniform(*extent)),
        float(rng.uniform(-np.pi / 2, np.pi / 2) if rng.random() < 0.6 else rng.normal(0.0, 0.15)),
        half_width,
        half_length,
        sign * float(rng.uniform(1.2, 4.0)),
    )


def add_clutter(bottom: Image, objects: tuple[ClutterObject, ...], x: Image, y: Image) -> Image:
    """Return the tone of a bottom at places x, y [texels] with objects added, float32 (H, W)."""
    low, high = float(y.min()), float(y.max())
    laid = bottom.copy()
    for item in objects:
        reach = item.half_length + 2 * item.half_width
        if not low - reach < item.y < high + reach:
            continue
        cos, sin = np.float32(np.cos(item.angle)), np.float32(np.sin(item.angle))
        right, up = x - np.float32(item.x), y - np.float32(item.y)
        across = right * cos + up * sin
        near = np.flatnonzero(np.abs(across) < 4 * item.half_width)
        across = across.reshape(-1)[near]
        along = up.reshape(-1)[near] * cos - right.reshape(-1)[near] * sin
        tone = PROFILES[item.kind](across, along, item.half_width)
        end = 2 * item.half_length if item.kind == "rock" else item.half_length
        fade = 1 - smooth_step(np.abs(along), 0.8 * end, end)
        laid.reshape(-1)[near] += np.float32(item.strength) * tone * fade
    return laid
