from __future__ import annotations

import numpy as np
import pytest
from message_parts import FACTORY, HEADER

from cable_tracker.sequences.messages.target_markers import make_target_markers
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.tracking.status import TrackingStatus


def estimate(status: TrackingStatus, outline: np.ndarray) -> TargetEstimate:
    box = (0.0, 0.0, 160.0, 120.0)
    return TargetEstimate(5, status, (320, 240), np.zeros(6), np.eye(6), box=box, outline=outline)


def test_markers_count_from_the_centre_of_the_image_with_y_up(sent):
    claimed = estimate(TrackingStatus.TRACKING, np.array([[160.0, 120.0], [320.0, 120.0]]))
    markers = sent(make_target_markers(FACTORY, HEADER, claimed)).markers
    assert [marker.ns for marker in markers] == ["", "image", "box", "contour"]
    first = markers[2].points[0]
    assert (first.x, first.y) == pytest.approx((-1.6, 1.2))
    ends = [coordinate for point in markers[3].points for coordinate in (point.x, point.y)]
    assert ends == pytest.approx([0.0, 0.0, 1.6, 0.0, 1.6, 0.0, 0.0, 0.0])


def test_without_a_contour_there_is_its_box():
    claimed = estimate(TrackingStatus.TRACKING, np.empty((0, 2)))
    markers = make_target_markers(FACTORY, HEADER, claimed).markers
    assert [marker.ns for marker in markers] == ["", "image", "box"]


def test_without_a_claim_the_markers_of_before_are_deleted():
    lost = estimate(TrackingStatus.LOST, np.empty((0, 2)))
    markers = make_target_markers(FACTORY, HEADER, lost).markers
    assert [marker.ns for marker in markers] == ["", "image"]
