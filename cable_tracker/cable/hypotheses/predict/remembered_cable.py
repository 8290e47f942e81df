"""Pose and width of the cable when it was last tracked, and the priors that follow from them.

The width changes slowly, as the diameter of a cable and the altitude of a vehicle do. So a rope
beside a cable that is overgrown just here is not taken for it, however clear its borders are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import inset, wrap_state
from cable_tracker.cable.model.state import DISTANCE, POSE_SIZE, WIDTH, pose_units
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import compiled_inside
from cable_tracker.particle_filter.student_t import relative_log_density

SPREAD = np.array([4.0, math.radians(2.0), 3.0, math.radians(1.0)])
"""Scales of the search about the last place, at first: d, alpha, w, beta [px at the reference
width, rad]."""

SPREADING = np.array([100.0, math.radians(37.0), 50.0, math.radians(7.5)])
"""Growth of these scales per second [px/s at the reference width, rad/s]."""

WIDEST = np.array([120.0, math.radians(60.0), 40.0, math.radians(10.0)])
"""Largest spread about the last place; a cable farther away is found by the uninformed search."""

LEFT_MARGIN = 3.0
"""A cable was leaving if it was nearer to the edge than this many `leaving_margin`."""

TAIL = 4.0
"""Degrees of freedom of the Student-t about the mean width."""

NARROWEST = 1e-3
"""Lower bound of a width whose logarithm is taken [px]."""

YOUNG_DOUBT = 3.0
"""Increase of the width prior's relative scale at first, decaying with `width_time`."""


@dataclass(frozen=True, slots=True, eq=False)
class RememberedCable:
    """Pose of the cable when it was last tracked, and the prior of its width.

    Attributes
    ----------
    pose : FloatArray
        d, alpha, w, beta, shape (4,) [px, rad].
    side : float
        Sign of d if it was leaving the image there; 0 if it was not.
    inset : float
        How far it was from leaving the image [px].
    log_width : float
        Logarithm of the running mean of the width while it was tracked [px].
    tracked_time : float
        Total time for which it was tracked [s].
    seconds : float
        Time since it was last tracked [s].
    """

    pose: FloatArray
    side: float
    inset: float
    log_width: float
    tracked_time: float = 0.0
    seconds: float = 0.0

    def scales(self, frame_scale: float) -> FloatArray:
        """Return the scales of births about the remembered pose, shape (4,) [px, rad].

        `frame_scale`: see `WorkingImage`.
        """
        scales = np.minimum(SPREAD + SPREADING * self.seconds, WIDEST)
        scaled: FloatArray = scales * pose_units(frame_scale)
        return scaled

    def width_spread(self, parameters: TrackerParameters) -> float:
        """Return the scale of the logarithm of the width, in the width prior.

        It grows with the time since the cable was tracked, and falls with the time for which it
        was.
        """
        doubt = YOUNG_DOUBT * math.exp(-self.tracked_time / parameters.width_time)
        growth = self.seconds / parameters.width_memory
        return parameters.width_spread * (1.0 + doubt + growth)

    def width_deviation(self, width: float, parameters: TrackerParameters) -> float:
        """Return the deviation of a width [px] from the prior: of its logarithm, in scales."""
        difference = math.log(max(width, NARROWEST)) - self.log_width
        return difference / self.width_spread(parameters)


@compiled_inside
def width_penalty(width: float, log_width: float, spread: float) -> float:
    """Return the log-density of a width [px] over its peak, at most 0; 0 for infinite spread."""
    if math.isinf(spread):
        return 0.0
    deviation = (math.log(max(width, NARROWEST)) - log_width) / spread
    return relative_log_density(deviation * deviation, TAIL, 1)


def remember(
    before: RememberedCable | None,
    leader: FloatArray,
    image_size: tuple[int, int],
    dt: float,
    parameters: TrackerParameters,
    frame_scale: float,
) -> RememberedCable:
    """Return the memory after a frame in which a cable is tracked.

    Parameters
    ----------
    before : RememberedCable or None
        The memory before the frame.
    leader : FloatArray
        State of the cable, shape (8,).
    image_size : (int, int)
        Width and height of the frames [px].
    dt : float
        Time since the frame before [s].
    parameters : TrackerParameters
        The tracker's parameters.
    frame_scale : float
        See `WorkingImage`.
    """
    state = wrap_state(leader)
    log_width, tracked_time = math.log(max(float(state[WIDTH]), NARROWEST)), 0.0
    if before is not None:
        share = -math.expm1(-dt / parameters.width_time)
        log_width = before.log_width + share * (log_width - before.log_width)
        tracked_time = before.tracked_time + dt
    within = inset(state, *image_size)
    is_leaving = within < LEFT_MARGIN * parameters.leaving_margin * frame_scale
    return RememberedCable(
        pose=state[:POSE_SIZE].copy(),
        side=float(np.sign(state[DISTANCE])) if is_leaving else 0.0,
        inset=within,
        log_width=log_width,
        tracked_time=tracked_time,
    )
