"""How the particles of the thesis move between two frames: within limits."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.cable.model.limits import StateLimits, clip_to_limits, state_limits
from cable_tracker.cable.model.movement import CableMovement, MotionAid
from cable_tracker.cable.model.state import DISTANCE, DISTANCE_RATE, POSE_SIZE
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.student_t import standard_student_t


class LimitedMovement(CableMovement):
    """Drift, diffusion, and what becomes of particles beyond a limit.

    Parameters
    ----------
    parameters : TrackerParameters
        Those of `CableMovement`, the limits, and how they are kept.
    image_width : int
        Width of the frames [px]; lengths scale with it.
    """

    def __init__(self, parameters: TrackerParameters, image_width: int) -> None:
        super().__init__(parameters, image_width)
        self._limits = state_limits(parameters, image_width)
        self._limit = (
            reflect_at_limits if parameters.limit_handling == "reflect" else clip_to_limits
        )

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
        moved = self.draw_centres(states, dt, rng, motion)
        diffusion = self.diffusion(dt, motion)
        pose, rates = (
            standard_student_t(rng, len(states), POSE_SIZE, self.degrees_of_freedom) * scales
            for scales in (diffusion.pose_scales, diffusion.rate_scales)
        )
        moved[:, :POSE_SIZE] += pose
        moved[:, POSE_SIZE:] += rates + pose * diffusion.rate_gains
        return self._limit(wrap_states(moved), self._limits)


def reflect_at_limits(states: FloatArray, limits: StateLimits) -> FloatArray:
    """Mirror components beyond a limit back inside, and turn the rate of d with it; shape (N, 8).

    Clipping piles particles up at the limit, where they agree with each other and with nothing
    else. What is still outside after one reflection is clipped.
    """
    result = states.copy()
    values = states[:, :POSE_SIZE]
    mirrored = np.where(values < limits.lower, 2 * limits.lower - values, values)
    mirrored = np.where(values > limits.upper, 2 * limits.upper - values, mirrored)
    result[:, :POSE_SIZE] = mirrored
    turned = np.abs(states[:, DISTANCE]) > limits.upper[DISTANCE]
    result[turned, DISTANCE_RATE] *= -1.0
    return clip_to_limits(result, limits)
