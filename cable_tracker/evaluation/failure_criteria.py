"""Tracking failure of a frame: two criteria, of which the second is stricter."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.cable.model.state import StateColumn
from cable_tracker.tracking.parameter_table import pixel_scale

LOST_DISTANCE = 10.0
"""An error of d that is forgiven however narrow the cable, in an image 320 px wide [px]."""

LOST_ANGLE = float(np.deg2rad(8.0))
"""An estimate that is turned by more has lost the cable [rad]."""


def is_off_cable(errors: FloatArray, widths: FloatArray, image_width: int) -> BoolArray:
    """Tell whether estimates are off by more than max(10 px, w/2) or 8 deg, shape (N,).

    What runs and tables count as a wrong claim: 10 px, those of an image 320 px wide, are forgiven
    of the thinnest cable, too. An error that is no number is off.

    Parameters
    ----------
    errors : FloatArray
        Estimate minus truth of d, alpha, ..., shape (N, >= 2) [px, rad].
    widths : FloatArray
        True widths w, shape (N,) [px].
    image_width : int
        Width of the frames [px].
    """
    allowance = np.maximum(LOST_DISTANCE * pixel_scale(image_width), widths / 2)
    held = (np.abs(errors[:, StateColumn.DISTANCE]) <= allowance) & (
        np.abs(errors[:, StateColumn.ANGLE]) <= LOST_ANGLE
    )
    return np.asarray(~held)


def is_outside_borders(errors: FloatArray, widths: FloatArray) -> BoolArray:
    """Tell whether estimates are off by more than w/2 or 8 deg, shape (N,).

    What is said of a recording with labels: a centreline outside the true borders, however thin the
    cable. Other than in `is_off_cable` no number of pixels is forgiven, and an error that is no
    number does not count.

    Parameters
    ----------
    errors, widths : FloatArray
        As in `is_off_cable`.
    """
    return np.asarray(
        (np.abs(errors[:, StateColumn.DISTANCE]) > widths / 2)
        | (np.abs(errors[:, StateColumn.ANGLE]) > LOST_ANGLE)
    )
