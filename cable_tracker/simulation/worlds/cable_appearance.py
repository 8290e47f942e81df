"""Appearance of a cable in a world: surface, contrast along its course, growth and sand on it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.simulation.rendering.texture import cloud_response, smooth_step, spectral_noise
from cable_tracker.simulation.worlds.catalogue import Coat, Cover, Range, Split, World
from cable_tracker.simulation.worlds.ground import sample_texture

PITCHES = (0.4, 2.5)
"""Smallest and largest distance along the cable from wire to wire [radii]; collars are
`COLLARS_APART` times as far apart."""

COLLARS_APART = 4.0

COLLAR_SHARE = 0.25
"""Share of the cable's length under collars."""

LONGEST_LAY = 1.5
"""How far along the cable wires run from its axis to a border [radii]."""

WAVES = 4
"""Number of waves that make a ragged border."""

WAVELENGTHS = (0.25, 3.0)
"""Shortest and longest of them [radii]."""

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


@dataclass(frozen=True, slots=True, eq=False)
class CableCoat:
    """The surface of one cable; attributes that `Coat` has the ranges of are as there.

    Attributes
    ----------
    collared : bool
        Whether the armour is collars instead of wires.
    pitch, lay : float
        Way from wire to wire, and how far along the cable a wire is at a border from where it is
        at the axis [radii].
    waves : FloatArray
        Angular frequency [1/radius], phase [rad] and amplitude [radii] of the waves of the left
        border, and of the right one, shape (2, `WAVES`, 3).
    """

    roughness: float
    roundness: float
    limbs: float
    lamp: float
    armour: float
    collared: bool
    pitch: float
    lay: float
    waves: FloatArray

    @property
    def reach(self) -> float:
        """Largest distance of a border from the axis, with some room [radii]."""
        return 1.2 + float(self.waves[..., 2].sum(axis=1).max())

    def tone(self, u: Image, v: Image, step: Image, skin: Image) -> Image:
        """Return the tone of the surface, float32: grey level over the mean of the bottom.

        In standard deviations of the bottom.

        Parameters
        ----------
        u, v : Image
            Across and along the cable [radii].
        step : Image
            Step at the borders there [standard deviations of the bottom].
        skin : Image
            Texture of mean 0 and standard deviation 1 there.
        """
        tone: Image = self.roughness * skin
        tone += step * (1 + np.float32(self.roundness) * (0.7 - np.minimum(u * u, 1.0)))
        if self.limbs > 0.0:
            tone -= self.darkening(u)
        if self.armour != 0.0:
            tone += np.float32(self.armour) * self._armour(u, v)
        return tone

    def darkening(self, u: Image) -> Image:
        """Return the darkening of places against the line that faces the lamp, float32."""
        aside = np.minimum(np.abs(u - np.float32(self.lamp)), 1.0)
        return np.asarray(np.float32(self.limbs) * (1 - np.sqrt(1 - aside * aside)), np.float32)

    def edge(self, u: Image, v: Image) -> Image | float:
        """Return the distance from the axis of the border on the side of places [radii]."""
        if not self.waves[..., 2].any():
            return 1.0
        left, right = (
            sum(
                np.float32(amplitude) * np.sin(v * np.float32(frequency) + np.float32(phase))
                for frequency, phase, amplitude in waves
            )
            for waves in self.waves
        )
        return np.asarray(1 + np.where(u < 0, left, right), np.float32)

    def _armour(self, u: Image, v: Image) -> Image:
        if self.collared:
            place = np.mod(v, np.float32(COLLARS_APART * self.pitch)) / (COLLARS_APART * self.pitch)
            rim = 0.25 * COLLAR_SHARE
            on = smooth_step(place, 0.0, rim) - smooth_step(place, COLLAR_SHARE, COLLAR_SHARE + rim)
            return np.asarray(on, np.float32)
        # Seen from above a wire around a cylinder is steeper the nearer it is to a border.
        around = np.arcsin(np.clip(u, -1.0, 1.0)) * np.float32(2 / np.pi)
        turns = (v + np.float32(self.lay) * around) * np.float32(2 * np.pi / self.pitch)
        return np.asarray(np.sin(turns), np.float32)


def random_coat(coat: Coat, split: Split, rng: np.random.Generator) -> CableCoat:
    """Draw the surface of a cable; what is drawn below 0 is 0, but for the lamp."""
    roughness, roundness = float(rng.uniform(*coat.roughness)), float(rng.uniform(*coat.roundness))
    # From here on with numbers of its own: what is drawn afterwards stays what it is.
    (rng,) = rng.spawn(1)
    frequencies = 2 * np.pi / rng.uniform(*WAVELENGTHS, (2, WAVES))
    phases = rng.uniform(0.0, 2 * np.pi, (2, WAVES))
    # The variance of a wave is half of its amplitude's square.
    amplitude = _positive(coat.raggedness, rng) * np.sqrt(2 / WAVES)
    return CableCoat(
        roughness=roughness,
        roundness=roundness,
        limbs=_positive(coat.limbs, rng),
        lamp=float(rng.uniform(*coat.lamp)),
        armour=_positive(coat.armour, rng) * float(rng.choice((-1.0, 1.0))),
        collared=split is Split.REPORT,
        pitch=float(rng.uniform(*PITCHES)),
        lay=float(rng.uniform(-LONGEST_LAY, LONGEST_LAY)),
        waves=np.stack((frequencies, phases, np.full((2, WAVES), amplitude)), axis=-1),
    )


def _positive(values: Range, rng: np.random.Generator) -> float:
    return max(float(rng.uniform(*values)), 0.0)


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
