"""How a cable moves in the image between two frames."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import POSE_SIZE
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import compiled, compiled_inside
from cable_tracker.particle_filter.student_t import standard_student_t
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, pixel_scale
from cable_tracker.tracking.rates import over_time

ALMOST_UNDAMPED = 1e-3
"""Logarithm of the damping over a gap, below which the sums of its powers are rounded away."""

DOUBT_STRIDE = 4
"""Every fourth state goes on by its own rates instead of odometry."""


class MotionAid(Protocol):
    """How the cable moves in the image from the frame before to this one, as odometry has it."""

    def moved(self, states: FloatArray) -> FloatArray:
        """Return states (N, 8) of the frame before as they are in this frame, angles not wrapped.

        Their rates become those of this motion.
        """
        ...

    def scales(self) -> FloatArray:
        """Return the scales of the diffusion over what is still unknown, shape (8,)."""
        ...


class Diffusion(NamedTuple):
    """How states spread about where they drift to.

    Attributes
    ----------
    pose_scales : FloatArray
        Scales of d, alpha, w, beta, shape (4,) [px, rad].
    rate_gains : FloatArray
        What a rate changes by, in the mean, for each pixel or radian that its component has spread:
        both come of the same changes of the rate within the gap, shape (4,) [1/s].
    rate_scales : FloatArray
        Scales of the rates about that, shape (4,) [px/s, rad/s].
    """

    pose_scales: FloatArray
    rate_gains: FloatArray
    rate_scales: FloatArray


@compiled_inside
def effective_time(damping: float, dt: float) -> float:
    """Return the time for which an undamped rate would cover the same way [s].

    Per reference frame a rate moves the cable by its value and is damped then, so that k frames
    cover 1 + a + ... + a^(k-1) = (1 - a^k) / (1 - a) of it. Without damping this is dt.
    """
    if damping == 1.0 or dt == 0.0:
        return dt
    # expm1, for a damping next to one would be rounded away in 1 - a^k.
    frames = dt * REFERENCE_RATE
    damped = -math.expm1(frames * math.log(damping)) if damping > 0.0 else 1.0
    return damped / (1.0 - damping) / REFERENCE_RATE


@compiled
def _drifted(states: FloatArray, damping: float, dt: float) -> FloatArray:
    """Return states (N, 8) after `dt` seconds at their rates, damped by a factor per frame."""
    moved, time, left = np.empty(states.shape), effective_time(damping, dt), over_time(damping, dt)
    for row in range(len(states)):
        for column in range(POSE_SIZE):
            rate = states[row, POSE_SIZE + column]
            moved[row, column] = states[row, column] + rate * time
            moved[row, POSE_SIZE + column] = rate * left
    return moved


class CableMovement:
    """Drift by the rates, then independent diffusion (thesis, sections 4.3.2 and 6.1).

    Parameters
    ----------
    parameters : TrackerParameters
        Squared scales of the diffusion, its variances if it is Gaussian (Table 5.1), tails and
        damping.
    image_width : int
        Width of the frames [px]; lengths scale with it.

    Attributes
    ----------
    degrees_of_freedom : float
        Degrees of freedom of the diffusion's Student-t; infinite for a Gaussian.
    """

    def __init__(self, parameters: TrackerParameters, image_width: int) -> None:
        self.degrees_of_freedom = parameters.diffusion_degrees_of_freedom or math.inf
        self._parameters = parameters
        self._per_frame = variances_per_frame(parameters, image_width)

    def draw_centres(
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
        moved[doubting] = self._by_rates_alone(states[doubting], dt, rng, motion)
        return moved

    def expected(
        self, states: FloatArray, dt: float, motion: MotionAid | None = None
    ) -> FloatArray:
        """Return where odometry or else the rates take states in `dt` seconds, shape (N, 8)."""
        if motion is None:
            return _drifted(np.ascontiguousarray(states), self._parameters.rate_damping, dt)
        moved = motion.moved(states)
        # Rates that the model never changes would stay for ever as odometry has left them.
        fixed = POSE_SIZE + np.flatnonzero(self._per_frame[1] == 0.0)
        moved[:, fixed] = states[:, fixed]
        return moved

    def _by_rates_alone(
        self, states: FloatArray, dt: float, rng: np.random.Generator, motion: MotionAid
    ) -> FloatArray:
        """Drift by the rates, and diffuse by what odometry has taken off the diffusion."""
        usual = variances_over(self._per_frame, self._parameters, dt)
        taken_off = np.sqrt(np.maximum(usual - self.diffusion_scales(dt, motion) ** 2, 0.0))
        tail = self.degrees_of_freedom
        noise = [standard_student_t(rng, len(states), POSE_SIZE, tail) for _ in range(2)]
        return self.expected(states, dt) + np.hstack(noise) * taken_off

    def diffusion_scales(self, dt: float, motion: MotionAid | None = None) -> FloatArray:
        """Return the scale of the diffusion over `dt` seconds, shape (8,).

        Odometry leaves less unknown, never more.
        """
        scales: FloatArray = np.sqrt(variances_over(self._per_frame, self._parameters, dt))
        return scales if motion is None else np.minimum(scales, motion.scales())

    def diffusion(self, dt: float, motion: MotionAid | None = None) -> Diffusion:
        """Return the diffusion over `dt` seconds, of the rates given that of the pose.

        What odometry leaves unknown of the pose says nothing of the rates.
        """
        scales = self.diffusion_scales(dt, motion)
        pose, rates = scales[:POSE_SIZE], scales[POSE_SIZE:]
        if motion is not None:
            return Diffusion(pose, np.zeros(POSE_SIZE), rates)
        covariances = covariances_over(self._per_frame, self._parameters, dt)
        gains = np.divide(covariances, pose**2, out=np.zeros(POSE_SIZE), where=covariances > 0.0)
        return Diffusion(pose, gains, np.sqrt(np.maximum(rates**2 - gains * covariances, 0.0)))


def variances_per_frame(
    parameters: TrackerParameters, image_width: int
) -> tuple[FloatArray, FloatArray]:
    """Return the variances that pose and rates gain in a reference frame, (4,) each [px², rad²]."""
    pixel = pixel_scale(image_width) ** 2
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


def covariances_over(
    per_frame: tuple[FloatArray, FloatArray], parameters: TrackerParameters, dt: float
) -> FloatArray:
    """Return the covariance of each component with its rate after `dt` seconds, (4,) [px²/s].

    It comes of changes of the rates within the time, see `variances_over`.
    """
    shared = _shared_with_rates(dt * REFERENCE_RATE, parameters.rate_damping)
    return per_frame[1] * shared * REFERENCE_RATE


def _kept_by_rates(frames: float, damping: float) -> float:
    """Return the variance of a damped rate after some frames, in units of that of one frame."""
    if damping == 1.0 or frames == 0.0:
        return frames
    log_damping = math.log(damping) if damping > 0.0 else -math.inf
    return math.expm1(2 * frames * log_damping) / math.expm1(2 * log_damping)


def _carried_by_rates(frames: float, damping: float) -> float:
    """Return the variance of the pose from rates that changed after the first of some frames.

    The sum of ((1 - a^k) / (1 - a))^2 over k from 1 to frames - 1, k^2 without damping, in a form
    that also holds between whole frames.
    """
    later = max(frames - 1.0, 0.0)
    if damping == 0.0:
        return later
    if _is_almost_undamped(later, damping):
        return later * (later + 1.0) * (2.0 * later + 1.0) / 6.0
    once, twice = (_sum_of_powers(damping, power, later) for power in (1, 2))
    return (later - 2.0 * once + twice) / (1.0 - damping) ** 2


def _shared_with_rates(frames: float, damping: float) -> float:
    """Return the covariance of the pose and its rate from changes of the rate over some frames.

    The sum of a^k (1 - a^k) / (1 - a) over k from 1 to frames - 1, of k without damping.
    """
    later = max(frames - 1.0, 0.0)
    if damping == 0.0:
        return 0.0
    if _is_almost_undamped(later, damping):
        return later * (later + 1.0) / 2.0
    once, twice = (_sum_of_powers(damping, power, later) for power in (1, 2))
    return (once - twice) / (1.0 - damping)


def _is_almost_undamped(frames: float, damping: float) -> bool:
    return -math.log(damping) * frames < ALMOST_UNDAMPED


def _sum_of_powers(damping: float, power: int, frames: float) -> float:
    """Return the sum of a^(power k) over k from 1 to `frames`, which need not be whole."""
    decay = -power * math.log(damping)
    return math.exp(-decay) * math.expm1(-decay * frames) / math.expm1(-decay)
