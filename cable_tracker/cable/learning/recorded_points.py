"""What is measured at points of borders, kept point by point so that it can be counted."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import Float32Array, FloatArray, IndexArray
from cable_tracker.cable.learning.point_measures import PointMeasures
from cable_tracker.cable.measure.borders.border_points import (
    BLOCK,
    border_line,
    find_crossings,
    measure_contrasts,
    measure_responses,
    room_for_crossings,
)
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.cable.measure.scanned_gradients import ScanInputs
from cable_tracker.cable.model.geometry import border_side
from cable_tracker.compilation import compiled


class BorderPoints(NamedTuple):
    """Where the borders of N cables cross the scan lines of a frame, inside it: P points.

    Attributes
    ----------
    measures : PointMeasures
        Response, slope and contrast at the points, each of shape (P,).
    borders : IndexArray
        Index of each point's border: twice that of the cable, plus one for the right; shape (P,).
    """

    measures: PointMeasures
    borders: IndexArray


def measure_points(states: FloatArray, image: WorkingImage) -> BorderPoints:
    """Measure the frame where the borders of cables, shape (N, 8), cross its scan lines."""
    scan = image.scan
    most = 2 * len(states) * max(len(scan.rows.places), len(scan.columns.places))
    measures, borders = np.empty((3, most), np.float32), np.empty(most, np.int64)
    count = _record_points(np.array(states, np.float64, order="C"), scan, measures, borders)
    return BorderPoints(PointMeasures(*measures[:, :count].copy()), borders[:count].copy())


@compiled
def _record_points(
    states: FloatArray, scan: ScanInputs, measures: Float32Array, borders: IndexArray
) -> int:
    """Fill in measures (3, most) and borders (most,) of the points; return how many there are."""
    count, crossings = 0, room_for_crossings()
    for border in range(2 * len(states)):
        line = border_line(states[border // 2], border_side(border % 2), scan)
        lines = scan.rows if line.is_steep else scan.columns
        for start in range(0, len(lines.places), BLOCK):
            first, found = find_crossings(lines, start, line, crossings)
            measure_responses(lines, first, found, line, crossings)
            measure_contrasts(lines, first, found, line, crossings)
            for index in range(found):
                measures[0, count + index] = crossings.responses[index]
                measures[1, count + index] = crossings.slopes[index]
                measures[2, count + index] = crossings.contrasts[index]
                borders[count + index] = border
            count += found
    return count
