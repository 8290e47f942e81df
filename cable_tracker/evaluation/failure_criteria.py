"""Tracking failure of a frame: an estimate that is off the cable."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.cable.model.state import ANGLE, DISTANCE
from cable_tracker.tracking.parameter_table import pixel_scale

LOST_DISTANCE = 10.0
"""An error of d that is forgiven however narrow the cable, in an image 320 px wide [px]."""

LOST_ANGLE = float(np.deg2rad(8.0))
"""An estimate that is turned by more has lost the cable [rad]."""


def forgiven_distance(image_width: int) -> float:
    """Return `LOST_DISTANCE` in images of a width [px]."""
    return LOST_DISTANCE * pixel_scale(image_width)


def forgiven_distances(image_widths: IndexArray) -> FloatArray:
    """Return `forgiven_distance` in images of several widths [px], shape (N,)."""
    return np.array([forgiven_distance(width) for width in image_widths.tolist()], np.float64)


def is_off_cable(
    errors: FloatArray, widths: FloatArray, *, forgiven: float | FloatArray
) -> BoolArray:
    """Tell whether estimates are off by more than max(forgiven, w/2) or 8 deg, shape (N,).

    An error that is no number is off.

    Parameters
    ----------
    errors : FloatArray
        Estimate minus truth of d, alpha, ..., shape (N, >= 2) [px, rad].
    widths : FloatArray
        True widths w, shape (N,) [px].
    forgiven : float or FloatArray
        Error of d that is forgiven however narrow the cable, one for all or shape (N,) [px]:
        `forgiven_distance` for what runs and tables count as a wrong claim; 0 for what is said of a
        recording with labels, a centreline outside the true borders.
    """
    allowance = np.maximum(forgiven, widths / 2)
    held = (np.abs(errors[:, DISTANCE]) <= allowance) & (np.abs(errors[:, ANGLE]) <= LOST_ANGLE)
    return np.asarray(~held)
