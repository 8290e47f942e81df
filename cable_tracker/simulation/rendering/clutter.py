"""Straight things that are not the cable: ropes across it, furrows and tracks beside it.

Places on the bottom are p across and q along the course of the cable, in its radii.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.simulation.rendering.laid_cable import Tube
from cable_tracker.simulation.rendering.texture import smooth_step

SPACING = 18.0
"""Mean distance between two streaks along the cable at full clutter [radii]."""


COMPANION_SPACING = 14.0
"""Mean distance between two companions along the cable where there are many [radii]."""


@dataclass(frozen=True, slots=True)
class Streak:
    """A straight band on the bottom, of finite length.

    Attributes
    ----------
    p, q : float
        Centre, across and along the cable [radii].
    angle : float
        Angle from the cable [rad].
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
    relief : float
        How much one slope of a furrow is lit and the other shaded, whatever the bottom is made of;
        negative for a wall of sand, 0 for something flat.
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
    relief: float = 0.0


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


def random_companions(
    tube: Tube, start: float, end: float, amount: float, rng: np.random.Generator
) -> tuple[Streak, ...]:
    """Lay furrows, ropes and pairs of lines alongside a cable from `start` to `end` [radii].

    They keep about the direction of the cable where they lie: scour and trenches follow it.
    """
    count = int(rng.poisson(max(end - start, 0.0) / COMPANION_SPACING * amount)) if amount else 0
    streaks: list[Streak] = []
    for place in np.sort(rng.uniform(start, end, count)):
        kind = rng.random()
        if kind < 0.45:
            found: tuple[Streak, ...] = (_scour(float(place), rng),)
        elif kind < 0.7:
            found = (_rope_alongside(float(place), rng),)
        else:
            found = _pair_alongside(float(place), rng)
        streaks.extend(_beside(tube, streak) for streak in found)
    return tuple(streaks)


def _beside(tube: Tube, streak: Streak) -> Streak:
    """Move a streak from coordinates about a cable's axis to those about its course."""
    points, directions = tube.axis(np.array([streak.q * tube.radius]))
    lean = float(np.arctan2(-directions[0, 0], directions[0, 1]))
    return replace(
        streak, p=streak.p + float(points[0, 0]) / tube.radius, angle=streak.angle + lean
    )


def _scour(q: float, rng: np.random.Generator) -> Streak:
    """Return a furrow that the current has washed out beside the cable, or a wall beside it."""
    return Streak(
        p=float(rng.choice((-1, 1)) * rng.uniform(1.6, 4.5)),
        q=q,
        angle=float(rng.normal(0.0, np.deg2rad(3))),
        half_width=float(rng.uniform(0.3, 0.8)),
        half_length=float(rng.uniform(10, 30)),
        tone=0.1,
        opacity=float(rng.uniform(0.0, 0.3)),
        twist=0.0,
        on_top=False,
        relief=float(rng.choice((-1, 1)) * rng.uniform(0.2, 0.5)),
    )


def _rope_alongside(q: float, rng: np.random.Generator) -> Streak:
    return replace(
        _random_rope(q, rng),
        p=float(rng.choice((-1, 1)) * rng.uniform(0.8, 5.0)),
        angle=float(rng.normal(0.0, np.deg2rad(7))),
        half_length=float(rng.uniform(8, 25)),
    )


def _pair_alongside(q: float, rng: np.random.Generator) -> tuple[Streak, Streak]:
    """Return two lines as far apart as the borders of a cable might be."""
    first = replace(_scour(q, rng), half_width=float(rng.uniform(0.15, 0.35)))
    apart = float(np.sign(first.p) * rng.uniform(1.2, 2.6))
    return first, replace(first, p=first.p + apart, relief=-first.relief)


def draw_streak(
    scene: Image, streak: Streak, p: Image, q: Image, travel: float, *, footprint: Image
) -> Image:
    """Return the reflected light of a scene with a streak laid on it, float32 (H, W).

    Parameters
    ----------
    scene : Image
        Reflected light, float32, shape (H, W).
    p, q, footprint : Image
        Bottom point of each pixel, `q` from `travel` on, and its extent there, of the same shape
        [radii].
    travel : float
        Position of the eye along the course [radii].
    """
    cover = streak_cover(streak, p, q, travel, footprint)
    if cover is None:
        return scene
    if streak.opacity > 0.0:
        scene = scene + (np.float32(streak.tone) - scene) * cover
    if streak.relief != 0.0:
        scene = scene * (1 + np.float32(streak.relief) * _slopes(streak, p, q, travel))
    return scene


def _slopes(streak: Streak, p: Image, q: Image, travel: float) -> Image:
    """Return the slope of a furrow's sides towards the light from the left, -1 to 1, (H, W)."""
    across, along = _places(streak, p, q, travel)
    u = across * np.float32(1 / streak.half_width)
    end = np.float32(streak.half_length)
    fade = 1 - smooth_step(np.abs(along), float(0.8 * end), float(end))
    return np.asarray(u * np.exp(np.float32(0.5) - np.float32(0.5) * u * u) * fade)


def _places(streak: Streak, p: Image, q: Image, travel: float) -> tuple[Image, Image]:
    """Return the coordinates of bottom points across a streak and along it [radii]."""
    cos, sin = np.float32(np.cos(streak.angle)), np.float32(np.sin(streak.angle))
    u, v = p - np.float32(streak.p), q - np.float32(streak.q - travel)
    return u * cos + v * sin, v * cos - u * sin


def streak_cover(
    streak: Streak, p: Image, q: Image, travel: float, footprint: Image
) -> Image | None:
    """Return the cover of each pixel by a streak, float32 (H, W), 0 to 1; None if out of view."""
    reach = streak.half_length + streak.half_width
    middle = streak.q - travel
    if middle + reach < q.min() or middle - reach > q.max():
        return None
    across, along = _places(streak, p, q, travel)
    across = np.abs(across)
    soft = 0.45 if streak.twist == 0.0 else 0.0
    edge = np.maximum(footprint, np.float32(soft))
    cover = np.clip((np.float32(streak.half_width) - across) / edge + 0.5, 0, 1)
    end = np.float32(streak.half_length)
    cover *= 1 - smooth_step(np.abs(along), float(0.92 * end), float(end))
    if streak.twist > 0.0:
        turns = (along + 0.8 * across) * np.float32(2 * np.pi / streak.twist)
        cover *= 0.85 + 0.15 * np.sin(turns)
    return cover * np.float32(streak.opacity)
