from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.baselines.hough import hough_peaks, zero_crossings
from cable_tracker.detection.border_lines import turn_between

SIZE = (320, 240)


def test_zero_crossings_lie_on_the_borders_between_the_pixels(draw_strip):
    pixels = draw_strip(CableState(0.3, 0.0, 40.0)).astype(np.float32)
    points = zero_crossings(pixels)
    columns = points.positions[np.abs(points.positions[:, 1]) < 100, 0]
    assert set(np.rint(columns * 2) / 2) <= {-20.0, -19.5, 20.0, 20.5}
    assert np.median(columns[columns < 0]) == pytest.approx(-19.7, abs=0.1)
    assert np.median(columns[columns > 0]) == pytest.approx(20.3, abs=0.1)


def test_directions_point_to_the_brighter_side(draw_strip):
    points = zero_crossings(draw_strip(CableState(0.0, 0.5, 40.0)).astype(np.float32))
    left = points.positions @ [np.cos(0.5), np.sin(0.5)] < 0
    away = np.where(left, 0.5, 0.5 + np.pi)
    assert np.median(np.abs(turn_between(points.directions, away))) < np.deg2rad(2)


@pytest.mark.parametrize("degrees", [-179, -90, -20, 0, 45, 90, 135, 180])
@pytest.mark.parametrize("offset", [-50.0, 0.0, 81.0])
def test_the_highest_peak_is_the_line(edge_line, degrees, offset):
    angles, offsets = hough_peaks(edge_line(np.deg2rad(degrees), offset), SIZE)
    assert abs(turn_between(angles[0], np.deg2rad(degrees))) < np.deg2rad(3)
    assert offsets[0] == pytest.approx(offset, abs=2.5)


def test_the_longer_line_has_the_higher_peak(edge_line, join):
    points = join(edge_line(0.0, -50.0, 0.0, 40.0), edge_line(1.0, 30.0))
    angles, _ = hough_peaks(points, SIZE)
    assert angles[0] == pytest.approx(1.0, abs=0.06)
