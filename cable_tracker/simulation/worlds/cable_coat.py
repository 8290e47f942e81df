"""Surface of a cable in a world, where nothing covers it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.simulation.rendering.texture import smooth_step
from cable_tracker.simulation.worlds.world import Coat, Range, Split

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
