"""Contrast of a cable in a world along its course, and the growth and sand that hide it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.simulation.rendering.texture import cloud_response, smooth_step, spectral_noise
from cable_tracker.simulation.worlds.ground import sample_texture
from cable_tracker.simulation.worlds.world import Cover, World

PATCHES_SIDE = 512
"""Rows and columns of the texture of patches [texels]."""

PATCHES_PER_RADIUS = 22.0
"""Texels of it on a radius of the cable."""

GROWTH_REACH = 1.3
"""Growth stands out over the borders to here [radii]."""

SAND_REACH = 2.4
"""Distance from the axis up to which sand over a border reaches [radii]."""

TURNS = (8.0, 30.0)
"""Shortest and longest period of the changes between bright and dark [radii]."""

SOFT_TURN, PAINTED_EDGE = 4.0, 60.0
"""Steepness of the changes of cables that are covered, and of those that are painted."""


@dataclass(frozen=True, slots=True)
class Drift:
    """Sand over one border of the cable.

    Attributes
    ----------
    start, end : float
        Along the cable [radii].
    side : int
        -1: over the left border; 1: over the right one.
    edge : float
        How far in it reaches, from the axis towards that side [radii]; negative: past the axis.
    tone : float
        [standard deviations of the bottom].
    """

    start: float
    end: float
    side: int
    edge: float
    tone: float


@dataclass(frozen=True, slots=True, eq=False)
class CableAppearance:
    """Contrast of one cable along its course, and what hides it.

    Attributes
    ----------
    step : float
        Brightness step at the borders, positive if bright [standard deviations of the bottom].
    turn_length, turn_phase : float
        Period of the changes between bright and dark [radii], 0 without any, and their phase at
        the start [rad].
    turn_steepness : float
        Steepness of that change.
    growth : float
        Share that growth covers.
    silt : float
        Share of the contrast that silt takes away.
    drifts : tuple of Drift
        Sand on it.
    place : (float, float)
        Start of the cable in the textures [texels].
    """

    step: float
    turn_length: float
    turn_phase: float
    turn_steepness: float
    growth: float
    silt: float
    drifts: tuple[Drift, ...]
    place: tuple[float, float]

    def contrast(self, v: Image) -> Image:
        """Return the step at the borders at places along the cable [radii], float32."""
        step = np.full(v.shape, self.step, np.float32)
        if self.turn_length > 0.0:
            turns = np.sin(v * np.float32(2 * np.pi / self.turn_length) + self.turn_phase)
            step *= np.tanh(np.float32(self.turn_steepness) * turns)
        if self.silt > 0.0:
            film = sample_texture(_patches(), v * np.float32(9.0) + self.place[1], np.zeros_like(v))
            step *= 1 - np.float32(self.silt) * smooth_step(film, -0.5, 1.0)
        return step

    def growth_cover(self, u: Image, v: Image) -> Image | None:
        """Return the cover of growth at places [radii], 0 to 1; None without any."""
        if self.growth <= 0.0:
            return None
        scale = np.float32(PATCHES_PER_RADIUS)
        level = sample_texture(_patches(), u * scale + self.place[0], v * scale + self.place[1])
        limit = NormalDist().inv_cdf(1.0 - min(self.growth, 0.95))
        reach = 1 - smooth_step(np.abs(u), GROWTH_REACH - 0.15, GROWTH_REACH)
        return np.asarray(smooth_step(level, limit - 0.12, limit + 0.12) * reach)

    def sand_covers(self, u: Image, v: Image, softness: Image | float) -> list[tuple[Image, float]]:
        """Return cover, 0 to 1, and tone of each drift of sand in view, at places [radii]."""
        low, high = float(v.min()), float(v.max())
        covers = []
        for drift in self.drifts:
            if not (drift.start < high and drift.end > low):
                continue
            ramp = 0.2 * (drift.end - drift.start)
            risen = smooth_step(v, drift.start, drift.start + ramp)
            risen = risen - smooth_step(v, drift.end - ramp, drift.end)
            waves = sample_texture(
                _patches(), v * np.float32(6.0) + self.place[0], np.zeros_like(v)
            )
            edge = drift.edge + 0.1 * waves + (1 - risen) * (SAND_REACH - drift.edge)
            inner = np.clip((drift.side * u - edge) / softness + 0.5, 0.0, 1.0)
            outer = 1 - smooth_step(drift.side * u, 1.2, SAND_REACH)
            covers.append((np.asarray(inner * outer, np.float32), drift.tone))
        return covers


@lru_cache(maxsize=1)
def _patches() -> Image:
    shape = (PATCHES_SIDE, PATCHES_SIDE)
    response = cloud_response(shape, 1.0, (26.0, 26.0), 1.5, 2.2)
    return spectral_noise(response, shape, np.random.default_rng(77))


def random_cable_appearance(
    world: World, extent: tuple[float, float], rng: np.random.Generator
) -> CableAppearance:
    """Draw the appearance of a cable of a world.

    Parameters
    ----------
    world : World
        Its `contrast`, `turning`, `bands` and `cover`.
    extent : (float, float)
        First and last position along the course that comes into view [radii].
    """
    low, high = np.log(world.contrast)
    step = float(np.exp(rng.uniform(low, high)) * rng.choice((-1.0, 1.0)))
    turns = rng.random() < world.turning
    turn_length = float(rng.uniform(*TURNS)) if turns else 0.0
    if world.bands is not None:
        turn_length = 2.0 * float(rng.uniform(*world.bands))
    return CableAppearance(
        step=step,
        turn_length=turn_length,
        turn_phase=float(rng.uniform(0.0, 2 * np.pi)),
        turn_steepness=SOFT_TURN if world.bands is None else PAINTED_EDGE,
        growth=float(rng.uniform(*world.cover.growth)),
        silt=float(rng.uniform(*world.cover.silt)),
        drifts=_random_drifts(world.cover, extent, rng),
        place=(float(rng.uniform(0, PATCHES_SIDE)), float(rng.uniform(0, PATCHES_SIDE))),
    )


def _random_drifts(
    cover: Cover, extent: tuple[float, float], rng: np.random.Generator
) -> tuple[Drift, ...]:
    share = float(rng.uniform(*cover.drift))
    if share <= 0.0:
        return ()
    bare = float(np.mean(cover.drift_lengths)) * (1 / share - 1)
    place, drifts = extent[0] + float(rng.uniform(0.0, bare)), []
    while place < extent[1]:
        length = float(rng.uniform(*cover.drift_lengths))
        drifts.append(
            Drift(
                place,
                place + length,
                int(rng.choice((-1, 1))),
                float(rng.uniform(-0.3, 0.7)),
                float(rng.normal(0.0, 0.6)),
            )
        )
        place += length + bare * float(rng.uniform(0.5, 1.5))
    return tuple(drifts)
