from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from message_parts import ESTIMATE, FACTORY, HEADER

from cable_tracker.errors import FrameError
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE, yaw_of
from cable_tracker.sequences.messages.target import (
    MOST_CORNERS,
    make_polygon,
    make_relative_pose,
    make_target,
    make_target_state,
    read_start,
    target_report_values,
)
from cable_tracker.tracking.status import TrackingStatus

LOST = replace(ESTIMATE, status=TrackingStatus.LOST)


def test_a_target_is_its_centre_with_its_angle(sent):
    pose = sent(make_target(FACTORY, HEADER, ESTIMATE)).pose
    assert (pose.pose.position.x, pose.pose.position.y) == (12.0, -8.0)
    assert yaw_of(pose.pose.orientation) == pytest.approx(0.3)
    variances = np.diag(pose.covariance.reshape(6, 6))
    assert variances.tolist() == [4.0, 9.0, *[UNKNOWN_VARIANCE] * 3, 0.04]


def test_a_place_in_metres_has_no_known_rotation(sent):
    message = make_relative_pose(FACTORY, HEADER, np.array([1.0, 2.0, 3.0]), np.eye(3))
    pose = sent(message).pose
    assert (pose.pose.position.x, pose.pose.position.y, pose.pose.position.z) == (1.0, 2.0, 3.0)
    assert (pose.pose.orientation.z, pose.pose.orientation.w) == (0.0, 1.0)
    variances = np.diag(pose.covariance.reshape(6, 6))
    assert variances.tolist() == [1.0] * 3 + [UNKNOWN_VARIANCE] * 3


def test_a_state_holds_the_size_in_pixels(sent):
    message = sent(make_target_state(FACTORY, HEADER, ESTIMATE))
    assert list(message.name) == ["x", "y", "size", "angle"]
    assert list(message.position) == [12.0, -8.0, 40.0, 0.3]
    assert list(message.velocity) == [2.0, -1.0, 0.0, 0.0]
    assert list(message.effort) == pytest.approx([2.0, 3.0, 4.0, 0.2])


@pytest.mark.parametrize("estimate", [LOST, None], ids=["lost", "none"])
def test_without_a_claim_there_are_no_numbers(sent, estimate):
    message = sent(make_target_state(FACTORY, HEADER, estimate))
    assert len(message.position) == len(message.velocity) == len(message.effort) == 0


def test_a_report_says_what_is_claimed_only_with_a_claim():
    claimed, lost = (target_report_values(each, 1.5, 0) for each in (ESTIMATE, LOST))
    assert (claimed["box"], claimed["corners"]) == ("150.0 100.0 190.0 140.0", "3")
    assert lost["box"] == lost["area"] == lost["scale"] == lost["corners"] == ""


def test_a_mark_is_read_as_it_was_sent(sent):
    start = read_start(sent(make_polygon(FACTORY, HEADER, ESTIMATE.outline)))
    np.testing.assert_array_equal(start.corners, ESTIMATE.outline)


def test_a_mark_of_too_many_corners_is_refused():
    corners = np.zeros((MOST_CORNERS + 1, 2))
    with pytest.raises(FrameError, match="corners"):
        read_start(make_polygon(FACTORY, HEADER, corners))
