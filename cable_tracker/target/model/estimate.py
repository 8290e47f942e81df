"""The estimate of a target after one frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.particle_filter.particles import standard_deviations
from cable_tracker.target.model.state import LOG_SCALE
from cable_tracker.tracking.status import TrackingStatus

Box = tuple[float, float, float, float]
"""Left, top, right, bottom from the top left corner of the picture, y downwards [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class TargetEstimate:
    """The posterior over the target after one frame.

    Attributes
    ----------
    stamp : int
        Time of the frame [ns].
    status : TrackingStatus
        Whether a target is claimed.
    image_size : (int, int)
        Width and height of the frame [px].
    state : FloatArray
        x, y, log scale, angle, v_x, v_y, shape (6,); origin at the image centre, y up [px, rad, per
        second]. The scale is that against the start, the angle in (-pi, pi]. Zeros before the first
        target.
    covariance : FloatArray
        Covariance of its error, shape (6, 6).
    box : Box or None
        Around the outline; None where there is none: before the first target, and where hardly
        anything of it is in the picture.
    outline : FloatArray
        Corners of the contour, column and row from the top left corner [px], shape (K, 2).
    area : float
        Area of the contour [px²].
    is_whole : bool
        Whether the contour agrees with the expected shape and does not reach the border, so that
        its size means something. Never of a bar of more than 1 by 14: the visible share of its
        length is unknown.
    presence : float
        Probability that the target is in view, 0 to 1.
    effective_sample_size : float
        N_eff, between 1 and N.
    score : float
        Mean log-likelihood ratio inside the estimated region less that around it.
    event : str
        Event that a user should know of; empty on ordinary frames.
    """

    stamp: int
    status: TrackingStatus
    image_size: tuple[int, int]
    state: FloatArray
    covariance: FloatArray
    box: Box | None = None
    outline: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    area: float = 0.0
    is_whole: bool = False
    presence: float = 0.0
    effective_sample_size: float = 1.0
    score: float = 0.0
    event: str = ""

    @property
    def is_claimed(self) -> bool:
        """Whether a target is claimed, with an outline."""
        return self.status is TrackingStatus.TRACKING and self.box is not None

    @property
    def scale(self) -> float:
        """Size against that at the start."""
        return float(np.exp(self.state[LOG_SCALE]))

    def standard_deviations(self) -> FloatArray:
        """Return the square roots of the covariance's diagonal, shape (6,)."""
        return standard_deviations(self.covariance)


def box_corners(box: Box) -> FloatArray:
    """Return the corners of a box, clockwise from the top left, shape (4, 2)."""
    left, top, right, bottom = box
    return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])
