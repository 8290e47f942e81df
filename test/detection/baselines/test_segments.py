from __future__ import annotations

import cv2
import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.detection.baselines.segments import Segments, lines_of_segments
from cable_tracker.detection.border_lines import gradient_of, turn_between


@pytest.fixture
def gradient(draw_strip):
    pixels = draw_strip(CableState(0.0, 0.0, 40.0)).astype(np.float32)
    return gradient_of(cv2.GaussianBlur(pixels, (0, 0), 1.0))


def segments(*ends) -> Segments:
    values = np.array(ends, dtype=float)
    return Segments(values[:, :2], values[:, 2:])


def test_pieces_of_one_border_become_one_line(gradient):
    pieces = segments((-20, -100, -20, -30), (-20.3, 80, -20.3, 20), (-20.1, 90, -20.1, 110))
    lines = lines_of_segments(pieces, gradient, 1.0)
    assert len(lines) == 1
    assert lines.offsets[0] * np.cos(lines.angles[0]) == pytest.approx(-20.1, abs=0.3)


@pytest.mark.parametrize("ends", [(-20, -100, -20, 100), (-20, 100, -20, -100)])
def test_the_normal_points_to_the_brighter_side_whichever_end_is_first(gradient, ends):
    lines = lines_of_segments(segments(ends), gradient, 1.0)
    assert turn_between(lines.angles[0], np.array(0.0)) == pytest.approx(0.0, abs=1e-6)
    assert lines.offsets[0] == pytest.approx(-20.0)


def test_the_other_border_has_the_opposite_normal(gradient):
    lines = lines_of_segments(segments((20, -100, 20, 100)), gradient, 1.0)
    assert abs(turn_between(lines.angles[0], np.array(np.pi))) == pytest.approx(0.0, abs=1e-6)
    assert lines.offsets[0] == pytest.approx(-20.0)


def test_a_segment_where_there_is_no_contrast_counts_for_nothing(gradient):
    assert len(lines_of_segments(segments((60, -100, 60, 100)), gradient, 1.0)) == 0


def test_the_length_of_a_segment_is_the_distance_between_its_ends():
    np.testing.assert_allclose(segments((0, 0, 3, 4), (1, 1, 1, 1)).lengths, [5.0, 0.0])
