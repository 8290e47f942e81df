"""Measures of points, for tests of what is learnt from them."""

from __future__ import annotations

import numpy as np

from cable_tracker.cable.measure.borders.response_bins import PointMeasures


def points(responses, slopes=0.0, contrasts=0.0) -> PointMeasures:
    arrays = np.broadcast_arrays(responses, slopes, contrasts)
    return PointMeasures(*(np.atleast_1d(np.asarray(array, np.float32)) for array in arrays))
