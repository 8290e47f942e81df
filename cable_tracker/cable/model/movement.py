"""How a cable moves in the image between two frames."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.cable.model.motion_aid import MotionAid
from cable_tracker.cable.model.state import POSE_SIZE, StateColumn
from cable_tracker.cable.parameters.parameters import (
    REFERENCE_RATE,
    REFERENCE_WIDTH,
    TrackerParameters,
)
from cable_tracker.particle_filter.student_t import standard_student_t

DOUBT_STRIDE = 4
"""One in so many states does not follow odometry."""


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
    """Set components beyond a limit to the limit; shape (N, 8)."""
    result = states.copy()
    result[:, :4] = np.clip(states[:, :4], limits.lower, limits.upper)
    return result


def reflect_at_limits(states: FloatArray, limits: StateLimits) -> FloatArray:
    """Mirror components beyond a limit back inside, and turn the rate of d with it; shape (N, 8).

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


def rate_damping_over(parameters: TrackerParameters, dt: float) -> float:
    """Return the factor on the rates over `dt` seconds."""
    return float(parameters.rate_damping ** (dt * REFERENCE_RATE))


def effective_time(parameters: TrackerParameters, dt: float) -> float:
    """Return the time for which an undamped rate would cover the same way [s].

    Per reference frame a rate moves the cable by its value and is damped then, so that k frames
    cover 1 + a + ... + a^(k-1) = (1 - a^k) / (1 - a) of it. Without damping this is dt.
    """
    damping = parameters.rate_damping
    if damping == 1.0:
        return dt
    # expm1, for a damping next to one would be rounded away in 1 - a^k.
    frames = dt * REFERENCE_RATE
    damped = -math.expm1(frames * math.log(damping)) if damping > 0.0 else 1.0
    return damped / (1.0 - damping) / REFERENCE_RATE


def variances_per_frame(
    parameters: TrackerParameters, image_width: int
) -> tuple[FloatArray, FloatArray]:
    """Return the variances that pose and rates gain in a reference frame, (4,) each [px², rad²]."""
    pixel = (image_width / REFERENCE_WIDTH) ** 2
    radian = np.deg2rad(1.0) ** 2
    pose = np.array(
        [
            parameters.distance_variance * pixel,
            parameters.angle_variance * radian,
            parameters.width_variance * pixel,
            parameters.skew_variance * radian,
        ]
    )
    rates = np.array(
        [
            parameters.distance_rate_variance * pixel,
            parameters.angle_rate_variance * radian,
            parameters.width_rate_variance * pixel,
            parameters.skew_rate_variance * radian,
        ]
    )
    return pose, rates


def variances_over(
    per_frame: tuple[FloatArray, FloatArray], parameters: TrackerParameters, dt: float
) -> FloatArray:
    """Return the variance that each component gains in `dt` seconds, shape (8,) [px², rad², per s].

    The thesis gives variances per frame, see `variances_per_frame`, and rates per frame: a rate per
    second is 25 times as large, its variance 625 times. Over a longer gap the changes of the rates
    within it move the cable too, so that the prior widens as it would have done frame by frame.
    """
    pose, rates = per_frame
    frames = dt * REFERENCE_RATE
    carried = _carried_by_rates(frames, parameters.rate_damping)
    kept = _kept_by_rates(frames, parameters.rate_damping)
    return np.concatenate((pose * frames + rates * carried, rates * kept * REFERENCE_RATE**2))


def _kept_by_rates(frames: float, damping: float) -> float:
    """Return the variance of a damped rate after some frames, in units of that of one frame."""
    if damping == 1.0 or frames == 0.0:
        return frames
    log_damping = math.log(damping) if damping > 0.0 else -math.inf
    return math.expm1(2 * frames * log_damping) / math.expm1(2 * log_damping)


def _carried_by_rates(frames: float, damping: float) -> float:
    """Return the variance of the pose from rates that changed after the first of some frames.

    The integral of ((1 - a^s) / (1 - a))^2 over s from 0 to frames - 1; s^2 without damping.
    """
    later = max(frames - 1.0, 0.0)
    if damping == 1.0:
        return later**3 / 3.0
    if damping == 0.0:
        return later
    decay = -math.log(damping)
    if decay * later < 1e-3:
        return later**3 / 3.0
    integral = (
        later
        + 2.0 * math.expm1(-decay * later) / decay
        - math.expm1(-2.0 * decay * later) / (2.0 * decay)
    )
    return integral / (1.0 - damping) ** 2


class CableMovement:
    """Drift by the rates, then independent diffusion (thesis, sections 4.3.2 and 6.1).

    Parameters
    ----------
    parameters : TrackerParameters
        Variances (Table 5.1), tails, damping and limits.
    image_width : int
        Width of the frames [px]; lengths scale with it.
    """

    def __init__(self, parameters: TrackerParameters, image_width: int) -> None:
        self._parameters = parameters
        self._per_frame = variances_per_frame(parameters, image_width)
        self._limits = state_limits(parameters, image_width)
        self._limit = (
            reflect_at_limits if parameters.limit_handling == "reflect" else clip_to_limits
        )

    @property
    def degrees_of_freedom(self) -> float:
        """Of the diffusion's Student-t distribution; infinite for a Gaussian."""
        return self._parameters.diffusion_degrees_of_freedom or math.inf

    def propagate(
        self,
        states: FloatArray,
        dt: float,
        rng: np.random.Generator,
        motion: MotionAid | None = None,
    ) -> FloatArray:
        """Draw the states `dt` seconds later, shape (N, 8), within the limits.

        `motion` is how odometry says that they have moved; None: by their own rates.
        """
        moved = self.centres(states, dt, rng, motion)
        sigmas = self.diffusion_sigmas(dt, motion).reshape(2, POSE_SIZE)
        for part, columns in enumerate((slice(0, POSE_SIZE), slice(POSE_SIZE, None))):
            noise = standard_student_t(rng, len(states), POSE_SIZE, self.degrees_of_freedom)
            moved[:, columns] += noise * sigmas[part]
        return self._limit(wrap_states(moved), self._limits)

    def centres(
        self,
        states: FloatArray,
        dt: float,
        rng: np.random.Generator,
        motion: MotionAid | None = None,
    ) -> FloatArray:
        """Draw what the diffusion over `dt` seconds is about, shape (N, 8).

        Without odometry, where the rates take the states. With it, where it says that they are; but
        one in `DOUBT_STRIDE` goes on by its rates, and astray as usual. So a filter that is beside
        the cable still finds it, and wrong odometry does not take everything along.
        """
        moved = self.expected(states, dt, motion)
        if motion is None:
            return moved
        doubting = slice(DOUBT_STRIDE - 1, None, DOUBT_STRIDE)
        moved[doubting] = self._astray(states[doubting], dt, rng, motion)
        return moved

    def expected(
        self, states: FloatArray, dt: float, motion: MotionAid | None = None
    ) -> FloatArray:
        """Return where odometry or else the rates take states in `dt` seconds, shape (N, 8)."""
        if motion is None:
            return self.drift(states, dt)
        moved = motion.moved(states)
        # Rates that the model never changes would stay for ever as odometry has left them.
        fixed = POSE_SIZE + np.flatnonzero(self._per_frame[1] == 0.0)
        moved[:, fixed] = states[:, fixed]
        return moved

    def _astray(
        self, states: FloatArray, dt: float, rng: np.random.Generator, motion: MotionAid
    ) -> FloatArray:
        """Drift by the rates, and diffuse by what odometry has taken off the diffusion."""
        usual = variances_over(self._per_frame, self._parameters, dt)
        taken_off = np.sqrt(np.maximum(usual - self.diffusion_sigmas(dt, motion) ** 2, 0.0))
        tail = self.degrees_of_freedom
        noise = [standard_student_t(rng, len(states), POSE_SIZE, tail) for _ in range(2)]
        return self.drift(states, dt) + np.hstack(noise) * taken_off

    def drift(self, states: FloatArray, dt: float) -> FloatArray:
        """Return where the rates alone take the states in `dt` seconds, shape (N, 8)."""
        moved = states.copy()
        moved[:, :POSE_SIZE] += states[:, POSE_SIZE:] * effective_time(self._parameters, dt)
        moved[:, POSE_SIZE:] *= rate_damping_over(self._parameters, dt)
        return moved

    def diffusion_sigmas(self, dt: float, motion: MotionAid | None = None) -> FloatArray:
        """Return the scale of the diffusion over `dt` seconds, shape (8,).

        Odometry leaves less unknown, never more.
        """
        sigmas: FloatArray = np.sqrt(variances_over(self._per_frame, self._parameters, dt))
        return sigmas if motion is None else np.minimum(sigmas, motion.sigmas())
