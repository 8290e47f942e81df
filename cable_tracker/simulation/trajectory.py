"""How the cable moves through the image while a vehicle follows it.

The motion is prescribed in the image: d, alpha, w and beta are smooth functions of time,
sums of slow sinusoids and single moves, so that position and velocity are known at every instant.
`borders.steer` finds the camera poses for it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import (
    ANGLE,
    ANGLE_RATE,
    DISTANCE,
    DISTANCE_RATE,
    SKEW,
    SKEW_RATE,
    STATE_SIZE,
    WIDTH,
    WIDTH_RATE,
)
from cable_tracker.errors import ParameterError
from cable_tracker.tracking.parameter_table import pixel_scale

RATE_STEP = 1e-4
"""Half the interval over which velocities are taken [s]."""

Bands = tuple[tuple[float, float], ...]
"""Lowest and highest frequency of each sinusoid [Hz]."""


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
        cls,
        limit: float,
        bands: Bands,
        rng: np.random.Generator,
        shares: tuple[float, ...] | None = None,
    ) -> Harmonics:
        """Draw frequencies from bands [Hz], and phases; the sum never exceeds +-limit.

        `shares` are the shares of the limit, one for each sinusoid. Without, they have equal
        velocities: slow ones are large, fast ones small.
        """
        low, high = np.array(bands).T
        frequencies = rng.uniform(low, high)
        parts = 1 / frequencies if shares is None else np.array(shares)
        return cls(
            amplitudes=limit * parts / parts.sum(),
            frequencies=2 * np.pi * frequencies,
            phases=rng.uniform(0.0, 2 * np.pi, len(bands)),
        )

    def values(self, times: FloatArray) -> FloatArray:
        """Return the sum at times [s], of the same shape."""
        phases = self.frequencies * times[..., None] + self.phases
        total: FloatArray = np.sum(self.amplitudes * np.sin(phases), axis=-1)
        return total

    def scaled(self, factor: float) -> Harmonics:
        """Return the same motion, larger or smaller."""
        return replace(self, amplitudes=factor * self.amplitudes)


@dataclass(frozen=True, slots=True)
class Move:
    """A single smooth change of a value from one level to another.

    Attributes
    ----------
    start, duration : float
        [s].
    amount : float
        In the unit of the value.
    """

    start: float
    duration: float
    amount: float

    def values(self, times: FloatArray) -> FloatArray:
        """Return the change at times (N,) [s]: 0 before the move, `amount` after it."""
        share = np.clip((times - self.start) / self.duration, 0.0, 1.0)
        risen: FloatArray = share**3 * (10 - share * (15 - 6 * share))
        return self.amount * risen


@dataclass(frozen=True, slots=True)
class Pause:
    """Standstill of a vehicle.

    Attributes
    ----------
    start, end : float
        Speed is 0 from here to here [s].
    ramp : float
        Duration of stopping, and of getting up to speed again [s].
    """

    start: float
    end: float
    ramp: float

    def lost(self, times: FloatArray) -> FloatArray:
        """Return the time lost until `times` (N,) [s]."""
        stopping = _integral_of_move((times - self.start + self.ramp) / self.ramp)
        starting = _integral_of_move((times - self.end) / self.ramp)
        return self.ramp * (stopping - starting)


def _integral_of_move(share: FloatArray) -> FloatArray:
    """Return the integral of a unit `Move` of unit duration from 0 to `share`."""
    risen = np.clip(share, 0.0, 1.0)
    integral: FloatArray = risen**4 * (2.5 - risen * (3 - risen)) + np.maximum(share - 1, 0.0)
    return integral


@dataclass(frozen=True, slots=True, eq=False)
class Signal:
    """A quantity that changes with time.

    Attributes
    ----------
    mean : float
        Initial level.
    harmonics : Harmonics
        Periodic components.
    moves : tuple of Move
        Single manoeuvres.
    strength : tuple of Move
        Changes of the harmonics' strength, which starts at 1.
    """

    mean: float
    harmonics: Harmonics
    moves: tuple[Move, ...] = ()
    strength: tuple[Move, ...] = ()

    def steady(self, times: FloatArray) -> FloatArray:
        """Return the mean and the moves, without the harmonics, at times (N,) [s]."""
        return self.mean + sum((move.values(times) for move in self.moves), np.zeros_like(times))

    def oscillation(self, times: FloatArray) -> FloatArray:
        """Return the harmonics alone at times (N,) [s]."""
        strength = sum((move.values(times) for move in self.strength), np.ones_like(times))
        oscillation: FloatArray = strength * self.harmonics.values(times)
        return oscillation

    def values(self, times: FloatArray) -> FloatArray:
        """Return the quantity at times [s], of the same shape."""
        return self.steady(times) + self.oscillation(times)

    def with_increment_variance(self, variance: float, times: FloatArray) -> Signal:
        """Scale the harmonics so that steps between `times` have the given sample variance.

        Raises
        ------
        ParameterError
            The variance of the moves alone is larger.
        """
        moves, waves = np.diff(self.steady(times)), np.diff(self.oscillation(times))
        both = np.cov(np.stack((moves, waves)))
        surplus = variance - both[0, 0]
        if surplus < 0:
            raise ParameterError(
                f"increment variance {variance:g} is less than the scripted moves alone cause "
                f"({both[0, 0]:g}): make them smaller or slower"
            )
        share = both[0, 1] / both[1, 1]
        factor = -share + float(np.sqrt(share**2 + surplus / both[1, 1]))
        return replace(self, harmonics=self.harmonics.scaled(factor))


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """The motion of a cable in the image, and of the vehicle along it.

    Attributes
    ----------
    distance, width : Signal
        d and w [px at the reference width].
    angle, skew : Signal
        alpha and beta [rad].
    roll : Signal
        Roll of the vehicle, right side down [rad].
    surge : Signal
        Travel along the cable besides that at the steady speed [m].
    speed : float
        Steady speed [m/s].
    pause : Pause or None
        Interval in which the vehicle stands still.
    """

    distance: Signal
    angle: Signal
    width: Signal
    skew: Signal
    roll: Signal
    surge: Signal
    speed: float
    pause: Pause | None = None

    def states(self, times: FloatArray, image_width: int) -> FloatArray:
        """Return d, alpha, w, beta and their rates, shape (N, 8) [px, rad, per second].

        The angle is not wrapped.
        """
        scale = pixel_scale(image_width)
        states = np.empty((times.size, STATE_SIZE))
        states[:, DISTANCE] = scale * self.distance.values(times)
        states[:, ANGLE] = self.angle.values(times)
        states[:, WIDTH] = scale * self.width.values(times)
        states[:, SKEW] = self.skew.values(times)
        states[:, DISTANCE_RATE] = scale * _rate(self.distance, times)
        states[:, ANGLE_RATE] = _rate(self.angle, times)
        states[:, WIDTH_RATE] = scale * _rate(self.width, times)
        states[:, SKEW_RATE] = _rate(self.skew, times)
        return states

    def travel(self, times: FloatArray) -> FloatArray:
        """Return the position along the cable, from that at time 0 [m], shape (N,)."""
        start = self.surge.values(np.zeros(1))
        lost = 0.0 if self.pause is None else self.pause.lost(times)
        return self.speed * (times - lost) + self.surge.values(times) - start


def _rate(signal: Signal, times: FloatArray) -> FloatArray:
    return (signal.values(times + RATE_STEP) - signal.values(times - RATE_STEP)) / (2 * RATE_STEP)
