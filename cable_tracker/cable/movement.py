"""How a cable moves in the image between two frames."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.geometry import wrap_states
from cable_tracker.cable.parameters import REFERENCE_RATE, REFERENCE_WIDTH, TrackerParameters
from cable_tracker.cable.state import StateColumn


@dataclass(frozen=True, slots=True, eq=False)
class StateLimits:
    """The box that particles stay in.

    Attributes
    ----------
    lower, upper : FloatArray
        Shape (4,): d, alpha, w, beta [px, rad]. The angle is not limited but wrapped.
    """

    lower: FloatArray
    upper: FloatArray


def state_limits(parameters: TrackerParameters, image_width: int) -> StateLimits:
    """Return the limits for frames of a given width [px]."""
    scale = image_width / REFERENCE_WIDTH
    skew = np.deg2rad(parameters.skew_limit)
    distance = parameters.distance_limit * scale
    return StateLimits(
        lower=np.array([-distance, -np.inf, parameters.width_minimum * scale, -skew]),
        upper=np.array([distance, np.inf, parameters.width_maximum * scale, skew]),
    )


def clip_to_limits(states: FloatArray, limits: StateLimits) -> FloatArray:
    """Set components beyond a limit to the limit; shape (N, 6)."""
    result = states.copy()
    result[:, :4] = np.clip(states[:, :4], limits.lower, limits.upper)
    return result


def reflect_at_limits(states: FloatArray, limits: StateLimits) -> FloatArray:
    """Mirror components beyond a limit back inside, and turn the rate of d with it; shape (N, 6).

    Clipping piles particles up at the limit, where they agree with each other and with nothing
    else. What is still outside after one reflection has no business inside and is clipped.
    """
    result = states.copy()
    values = states[:, :4]
    mirrored = np.where(values < limits.lower, 2 * limits.lower - values, values)
    mirrored = np.where(values > limits.upper, 2 * limits.upper - values, mirrored)
    result[:, :4] = mirrored
    turned = np.abs(states[:, StateColumn.DISTANCE]) > limits.upper[StateColumn.DISTANCE]
    result[turned, StateColumn.DISTANCE_RATE] *= -1.0
    return clip_to_limits(result, limits)


def diffusion_per_second(parameters: TrackerParameters, image_width: int) -> FloatArray:
    """Return the variance that each component gains per second, shape (6,) [px², rad², per s].

    The thesis gives variances per frame, and rates per frame: a rate per second is 25 times as
    large, its variance 625 times.
    """
    pixel = (image_width / REFERENCE_WIDTH) ** 2
    radian = np.deg2rad(1.0) ** 2
    rate = REFERENCE_RATE**2
    per_frame = np.array(
        [
            parameters.distance_variance * pixel,
            parameters.angle_variance * radian,
            parameters.width_variance * pixel,
            parameters.skew_variance * radian,
            parameters.distance_rate_variance * pixel * rate,
            parameters.angle_rate_variance * radian * rate,
        ]
    )
    return per_frame * REFERENCE_RATE


class CableMovement:
    """Drift by the rates, then independent Gaussian diffusion (thesis, section 4.3.2).

    Parameters
    ----------
    parameters : TrackerParameters
        Variances (Table 5.1), damping and limits.
    image_width : int
        Width of the frames [px]; lengths scale with it.
    """

    def __init__(self, parameters: TrackerParameters, image_width: int) -> None:
        self._diffusion = diffusion_per_second(parameters, image_width)
        self._damping = parameters.rate_damping
        self._limits = state_limits(parameters, image_width)
        self._limit = (
            reflect_at_limits if parameters.limit_handling == "reflect" else clip_to_limits
        )

    def propagate(self, states: FloatArray, dt: float, rng: np.random.Generator) -> FloatArray:
        """Draw the states `dt` seconds later, shape (N, 6), within the limits."""
        rates = states[:, [StateColumn.DISTANCE_RATE, StateColumn.ANGLE_RATE]]
        moved = states.copy()
        moved[:, [StateColumn.DISTANCE, StateColumn.ANGLE]] += rates * self._effective_time(dt)
        moved[:, [StateColumn.DISTANCE_RATE, StateColumn.ANGLE_RATE]] *= self._damping_over(dt)
        moved += rng.standard_normal(states.shape) * np.sqrt(self._diffusion * dt)
        return self._limit(wrap_states(moved), self._limits)

    def _damping_over(self, dt: float) -> float:
        return float(self._damping ** (dt * REFERENCE_RATE))

    def _effective_time(self, dt: float) -> float:
        """Return the time for which an undamped rate would cover the same way [s].

        Per reference frame a rate moves the cable by its value and is damped then, so that k frames
        cover 1 + a + ... + a^(k-1) = (1 - a^k) / (1 - a) of it. Without damping this is dt.
        """
        if self._damping == 1.0:
            return dt
        # expm1, for a damping next to one would be rounded away in 1 - a^k.
        frames = dt * REFERENCE_RATE
        damped = -math.expm1(frames * math.log(self._damping)) if self._damping > 0.0 else 1.0
        return damped / (1.0 - self._damping) / REFERENCE_RATE
