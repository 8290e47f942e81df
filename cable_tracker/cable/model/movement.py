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
"""Negative logarithm of the damping over a gap; below it, rounding spoils the sums of powers."""

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
        Regression of the diffusion of a rate on that of its component: both come of the same
        changes of the rate within the gap, shape (4,) [1/s].
    rate_scales : FloatArray
        Scales of the rates about that regression, shape (4,) [px/s, rad/s].
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

        Without odometry, where the rates take the states. With it, where odometry takes them, but
        for one in `DOUBT_STRIDE`, which goes on by its rates and spreads as without odometry: so a
        filter beside the cable still finds it, and wrong odometry does not move all particles.
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
        # Rates without diffusion would keep the value of odometry for ever.
        fixed = POSE_SIZE + np.flatnonzero(self._per_frame[1] == 0.0)
        moved[:, fixed] = states[:, fixed]
        return moved

    def _by_rates_alone(
        self, states: FloatArray, dt: float, rng: np.random.Generator, motion: MotionAid
    ) -> FloatArray:
        """Drift by the rates, and diffuse by what odometry has taken off the diffusion."""
        usual, _ = gained_spread(self._per_frame, self._parameters.rate_damping, dt)
        aided = np.minimum(np.sqrt(usual), motion.scales())
        taken_off: FloatArray = np.sqrt(np.maximum(usual - aided**2, 0.0))
        tail = self.degrees_of_freedom
        noise = [standard_student_t(rng, len(states), POSE_SIZE, tail) for _ in range(2)]
        return self.expected(states, dt) + np.hstack(noise) * taken_off

    def diffusion(self, dt: float, motion: MotionAid | None = None) -> Diffusion:
        """Return the diffusion over `dt` seconds, of the rates given that of the pose.

        Odometry leaves less unknown, never more, and what it leaves unknown of the pose says
        nothing of the rates.
        """
        variances, covariances = gained_spread(self._per_frame, self._parameters.rate_damping, dt)
        scales = np.sqrt(variances)
        if motion is not None:
            scales = np.minimum(scales, motion.scales())
            return Diffusion(scales[:POSE_SIZE], np.zeros(POSE_SIZE), scales[POSE_SIZE:])
        pose, rates = scales[:POSE_SIZE], scales[POSE_SIZE:]
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


def gained_spread(
    per_frame: tuple[FloatArray, FloatArray], damping: float, dt: float
) -> tuple[FloatArray, FloatArray]:
    """Return the variances and covariances that a state gains in `dt` seconds.

    The thesis gives variances per frame, and rates per frame: a rate per second is 25 times as
    large, its variance 625 times. Over a longer gap the changes of the rates within it move the
    cable too, so that the prior widens as it would have done frame by frame.

    Parameters
    ----------
    per_frame : (FloatArray, FloatArray)
        Those of `variances_per_frame`.
    damping : float
        Factor a on a rate per reference frame, 0 to 1.
    dt : float
        Time [s].

    Returns
    -------
    variances : FloatArray
        Of the components of the state, shape (8,) [px², rad², per s²].
    covariances : FloatArray
        Of d, alpha, w, beta with their rates, shape (4,) [px²/s, rad²/s].
    """
    pose, rates = per_frame
    frames = dt * REFERENCE_RATE
    carried, kept, shared = _sums_over_frames(frames, damping)
    variances = np.concatenate((pose * frames + rates * carried, rates * kept * REFERENCE_RATE**2))
    return variances, rates * shared * REFERENCE_RATE


def _sums_over_frames(frames: float, damping: float) -> tuple[float, float, float]:
    """Return what n frames add to the spread, in units of a rate's variance of one frame.

    The sums are written in a form that also holds between whole frames. With the damping a, and
    m_k = (1 - a^k) / (1 - a) the way of k frames (k without damping):

    Returns
    -------
    carried : float
        Variance of the pose from changes of the rate: sum of m_k^2, k from 1 to n - 1.
    kept : float
        Variance of the rate: sum of a^(2k), k from 0 to n - 1.
    shared : float
        Covariance of both: sum of a^k m_k, k from 1 to n - 1.
    """
    later = max(frames - 1.0, 0.0)
    log_damping = math.log(damping) if damping > 0.0 else -math.inf
    kept = frames
    if damping < 1.0 and frames > 0.0:
        kept = math.expm1(2 * frames * log_damping) / math.expm1(2 * log_damping)
    if damping == 0.0:
        return later, kept, 0.0
    if -log_damping * later < ALMOST_UNDAMPED:
        carried = later * (later + 1.0) * (2.0 * later + 1.0) / 6.0
        return carried, kept, later * (later + 1.0) / 2.0
    once, twice = (_sum_of_powers(damping, power, later) for power in (1, 2))
    carried = (later - 2.0 * once + twice) / (1.0 - damping) ** 2
    return carried, kept, (once - twice) / (1.0 - damping)


def _sum_of_powers(damping: float, power: int, frames: float) -> float:
    """Return the sum of a^(power k) over k from 1 to `frames`, which need not be whole."""
    decay = -power * math.log(damping)
    return math.exp(-decay) * math.expm1(-decay * frames) / math.expm1(-decay)
