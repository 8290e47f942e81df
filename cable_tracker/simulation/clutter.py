"""Straight things that are not the cable: ropes across it, furrows and tracks beside it.

Places on the bottom are p across and q along the course of the cable, in its radii.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.simulation.texture import smooth_step

SPACING = 18.0
"""Mean distance between two streaks along the cable at full clutter [radii]."""


@dataclass(frozen=True, slots=True)
class Streak:
    """A straight band on the bottom, of finite length.

    Attributes
    ----------
    p, q : float
        Its middle, across and along the cable [radii].
    angle : float
        Its angle from the cable [rad].
    half_width, half_length : float
        [radii].
    tone : float
        Reflected light, 0 to 1.
    opacity : float
        0 to 1.
    twist : float
        Length of one turn of a rope [radii]; 0 for something without a pattern.
    on_top : bool
        Whether it lies over the cable, or the cable over it.
    """

    p: float
    q: float
    angle: float
    half_width: float
    half_length: float
    tone: float
    opacity: float
    twist: float
    on_top: bool


def random_streaks(
    start: float, end: float, clutter: float, rng: np.random.Generator
) -> tuple[Streak, ...]:
    """Strew ropes and furrows along the cable from `start` to `end` [radii]."""
    count = int(rng.poisson(max(end - start, 0.0) / SPACING * clutter)) if clutter > 0 else 0
    streaks: list[Streak] = []
    for place in np.sort(rng.uniform(start, end, count)):
        kind = rng.random()
        if kind < 0.1:
            streaks.extend(random_track(float(place), rng))
        else:
            make = _random_rope if kind < 0.5 else _random_furrow
            streaks.append(make(float(place), rng))
    return tuple(streaks)


def random_track(q: float, rng: np.random.Generator) -> tuple[Streak, Streak]:
    """Return the two furrows that something dragged over the bottom has left."""
    middle = float(rng.choice((-1, 1)) * rng.uniform(4, 11))
    angle = float(rng.normal(0.0, np.deg2rad(25)))
    half_width, apart = float(rng.uniform(0.2, 0.4)), float(rng.uniform(0.8, 2.0))
    first = Streak(
        p=middle - apart * float(np.cos(angle)),
        q=q - apart * float(np.sin(angle)),
        angle=angle,
        half_width=half_width,
        half_length=float(rng.uniform(20, 50)),
        tone=float(rng.choice((0.13, 0.2))),
        opacity=float(rng.uniform(0.35, 0.55)),
        twist=0.0,
        on_top=False,
    )
    second = replace(
        first, p=middle + apart * float(np.cos(angle)), q=q + apart * float(np.sin(angle))
    )
    return first, second


def _random_rope(q: float, rng: np.random.Generator) -> Streak:
    angle = rng.choice((-1, 1)) * rng.uniform(np.deg2rad(25), np.deg2rad(90))
    return Streak(
        p=float(rng.uniform(-3, 3)),
        q=q,
        angle=float(angle),
        half_width=float(rng.uniform(0.1, 0.2)),
        half_length=float(rng.uniform(6, 25)),
        tone=float(rng.choice((0.12, 0.6))),
        opacity=0.85,
        twist=float(rng.uniform(0.3, 0.5)),
        on_top=bool(rng.random() < 0.7),
    )


def _random_furrow(q: float, rng: np.random.Generator) -> Streak:
    return Streak(
        p=float(rng.choice((-1, 1)) * rng.uniform(3, 9)),
        q=q,
        angle=float(rng.normal(0.0, np.deg2rad(20))),
        half_width=float(rng.uniform(0.25, 0.7)),
        half_length=float(rng.uniform(6, 20)),
        tone=float(rng.choice((0.14, 0.46))),
        opacity=float(rng.uniform(0.35, 0.65)),
        twist=0.0,
        on_top=False,
    )


def streak_cover(
    streak: Streak, p: Image, q: Image, travel: float, footprint: Image
) -> Image | None:
    """Return how much a streak covers each pixel, float32 (H, W), 0 to 1; None if out of sight."""
    reach = streak.half_length + streak.half_width
    middle = streak.q - travel
    if middle + reach < q.min() or middle - reach > q.max():
        return None
    cos, sin = np.float32(np.cos(streak.angle)), np.float32(np.sin(streak.angle))
    u, v = p - np.float32(streak.p), q - np.float32(middle)
    across = np.abs(u * cos + v * sin)
    along = v * cos - u * sin
    soft = 0.45 if streak.twist == 0.0 else 0.0
    edge = np.maximum(footprint, np.float32(soft))
    cover = np.clip((np.float32(streak.half_width) - across) / edge + 0.5, 0, 1)
    end = np.float32(streak.half_length)
    cover *= 1 - smooth_step(np.abs(along), float(0.92 * end), float(end))
    if streak.twist > 0.0:
        turns = (along + 0.8 * across) * np.float32(2 * np.pi / streak.twist)
        cover *= 0.85 + 0.15 * np.sin(turns)
    return cover * np.float32(streak.opacity)
