"""How the cable moves through the image while a vehicle follows it.

The camera sways over the cable: distance, angle, width and the tilt of the camera are sums of a few
slow sinusoids, so that position and velocity are known exactly at every instant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.state import CableState

REFERENCE_WIDTH = 320
"""The image width that lengths in pixels are given for."""

DISTANCE_LIMIT = 70.0
"""Largest |d| [px at the reference width]."""

ANGLE_LIMIT = np.deg2rad(25.0)
"""Largest |alpha| [rad]."""

WIDTH_LIMITS = (24.0, 48.0)
"""Smallest and largest w [px at the reference width]."""

HORIZON_LIMITS = (1.15, 3.3)
"""Nearest and farthest vanishing point of the borders [half diagonals of the image].

Borders that meet at the distance s have the skew atan(w / 2 s). The point stays outside the image,
where the bottom would end; at 4:3 the skews lie between 1 and 6 degrees.
"""

SPEED_LIMITS = (2.5, 4.5)
"""Forward speed over the bottom [radii of the cable per second]."""

SWAY_AMPLITUDES = (0.3, 0.4, 0.2, 0.1)
"""Shares of the limit that the sinusoids take: slow wandering first, then faster and smaller."""

SWAY_BANDS = ((0.008, 0.03), (0.12, 0.2), (0.25, 0.45), (0.5, 0.75))
"""Frequencies of the sinusoids of d and alpha [Hz], lowest and highest of each."""

DRIFT_BANDS = ((0.008, 0.02), (0.03, 0.06), (0.07, 0.12), (0.15, 0.2))
"""Frequencies of the sinusoids of altitude and tilt [Hz], lowest and highest of each."""


@dataclass(frozen=True, slots=True, eq=False)
class Harmonics:
    """A sum of sinusoids of time.

    Attributes
    ----------
    amplitudes : FloatArray
        Shape (K,), in the unit of the value.
    frequencies : FloatArray
        Shape (K,) [rad/s].
    phases : FloatArray
        Shape (K,) [rad].
    """

    amplitudes: FloatArray
    frequencies: FloatArray
    phases: FloatArray

    @classmethod
    def random(
        cls, limit: float, bands: tuple[tuple[float, float], ...], rng: np.random.Generator
    ) -> Harmonics:
        """Draw frequencies from bands [Hz], and phases; the sum never exceeds +-limit."""
        low, high = np.array(bands).T
        return cls(
            amplitudes=limit * np.array(SWAY_AMPLITUDES),
            frequencies=2 * np.pi * rng.uniform(low, high),
            phases=rng.uniform(0.0, 2 * np.pi, len(bands)),
        )

    def value(self, time: float) -> float:
        """Return the sum at a time [s]."""
        return float(np.sum(self.amplitudes * np.sin(self.frequencies * time + self.phases)))

    def rate(self, time: float) -> float:
        """Return the derivative of the sum at a time [s], per second."""
        phases = self.frequencies * time + self.phases
        return float(np.sum(self.amplitudes * self.frequencies * np.cos(phases)))


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """The motion of a cable in the image, exact at any time.

    Attributes
    ----------
    image_size : (int, int)
        Width and height of the image [px]; lengths scale with the width.
    distance, angle : Harmonics
        d [px] and alpha [rad].
    altitude : Harmonics
        Between -1 (widest cable) and 1 (narrowest).
    tilt : Harmonics
        Between -1 (looking straight down) and 1 (looking ahead most).
    surge : Harmonics
        Deviation from the steady forward motion [radii of the cable].
    speed : float
        Steady forward speed [radii of the cable per second].
    """

    image_size: tuple[int, int]
    distance: Harmonics
    angle: Harmonics
    altitude: Harmonics
    tilt: Harmonics
    surge: Harmonics
    speed: float

    @classmethod
    def random(cls, image_size: tuple[int, int], rng: np.random.Generator) -> Trajectory:
        """Draw a trajectory for images of the given width and height [px]."""
        scale = image_size[0] / REFERENCE_WIDTH
        return cls(
            image_size=image_size,
            distance=Harmonics.random(DISTANCE_LIMIT * scale, SWAY_BANDS, rng),
            angle=Harmonics.random(ANGLE_LIMIT, SWAY_BANDS, rng),
            altitude=Harmonics.random(1.0, DRIFT_BANDS, rng),
            tilt=Harmonics.random(1.0, DRIFT_BANDS, rng),
            surge=Harmonics.random(1.0, DRIFT_BANDS, rng),
            speed=float(rng.uniform(*SPEED_LIMITS)),
        )

    def state(self, time: float) -> CableState:
        """Return where the cable is at a time [s], with its velocities per second."""
        width = self._width(time)
        return CableState(
            distance=self.distance.value(time),
            angle=self.angle.value(time),
            width=width,
            skew=float(np.arctan(width / 2 / self._horizon(time))),
            distance_rate=self.distance.rate(time),
            angle_rate=self.angle.rate(time),
        )

    def travel(self, time: float) -> float:
        """Return the way along the cable since the start [radii of the cable]; never backwards."""
        return self.speed * time + self.surge.value(time) - self.surge.value(0.0)

    def _width(self, time: float) -> float:
        narrowest, widest = WIDTH_LIMITS
        middle, swing = (widest + narrowest) / 2, (widest - narrowest) / 2
        width = middle - swing * self.altitude.value(time)
        return width * self.image_size[0] / REFERENCE_WIDTH

    def _horizon(self, time: float) -> float:
        """Return the distance from the foot point to where the borders meet [px]."""
        nearest, farthest = HORIZON_LIMITS
        share = (1 + self.tilt.value(time)) / 2
        curvature = 1 / farthest + share * (1 / nearest - 1 / farthest)
        return float(np.hypot(*self.image_size) / 2 / curvature)
