"""Measures of points, and what a table says of them, for the tests of borders and of learning."""

from __future__ import annotations

import numpy as np

from cable_tracker.cable.learning.point_measures import PointMeasures
from cable_tracker.cable.measure.borders.response_table import CONTRAST_BINS, ResponseTable


def points(responses, slopes=0.0, contrasts=0.0) -> PointMeasures:
    arrays = np.broadcast_arrays(responses, slopes, contrasts)
    return PointMeasures(*(np.atleast_1d(np.asarray(array, np.float32)) for array in arrays))


def ratios_at(points: PointMeasures, table: ResponseTable) -> np.ndarray:
    """Look up P points on borders: those of bright cables by class, then of dark ones, (P, 8)."""
    edges, contrasts = points.cells()
    return table.ratios[edges * CONTRAST_BINS + contrasts % CONTRAST_BINS]
