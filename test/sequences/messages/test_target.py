from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from message_parts import ESTIMATE, FACTORY, HEADER

from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.frame_report import report_facts, report_status
from cable_tracker.sequences.messages.point_cloud import make_point_cloud
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE, yaw_of
from cable_tracker.sequences.messages.target import (
    MOST_CORNERS,
    TARGET_CLOUD_COLUMNS,
    make_polygon,
    make_relative_pose,
    make_target,
    make_target_markers,
    make_target_particles,
    make_target_state,
    messages_without_target,
    read_start,
    read_target_particles,
    target_messages,
    target_report_values,
)
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.tracking.status import TrackingStatus

LOST = replace(ESTIMATE, status=TrackingStatus.LOST)


def test_a_target_is_its_centre_with_its_angle(sent):
    pose = sent(make_target(FACTORY, HEADER, ESTIMATE)).pose
    assert (pose.pose.position.x, pose.pose.position.y) == (12.0, -8.0)
    assert yaw_of(pose.pose.orientation) == pytest.approx(0.3)
    variances = np.diag(pose.covariance.reshape(6, 6))
    assert variances.tolist() == [4.0, 9.0, *[UNKNOWN_VARIANCE] * 3, 0.04]


def test_a_position_in_metres_has_no_known_rotation(sent):
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


def test_a_report_describes_the_target_only_with_a_claim():
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


def test_particles_are_kept_with_their_scale(sent):
    states = np.array([[1.0, 2.0, np.log(2.0), 0.5, 3.0, 4.0]])
    message = make_target_particles(FACTORY, HEADER, Particles.equally_weighted(states))
    found = read_target_particles(sent(message))
    assert found.tolist() == [[1.0, 2.0, 2.0, 0.5, 3.0, 4.0, 1.0]]


def test_an_empty_cloud_has_no_particles(sent):
    columns = len(TARGET_CLOUD_COLUMNS)
    message = make_point_cloud(FACTORY, HEADER, TARGET_CLOUD_COLUMNS, np.empty((0, columns)))
    assert read_target_particles(sent(message)) is None


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


def test_without_a_claim_earlier_markers_are_deleted():
    lost = estimate(TrackingStatus.LOST, np.empty((0, 2)))
    markers = make_target_markers(FACTORY, HEADER, lost).markers
    assert [marker.ns for marker in markers] == ["", "image"]


PARTICLES = Particles(np.zeros((5, 6)), np.full(5, 0.2))
ALWAYS = {node_topics.STATE, node_topics.TARGET_REPORT, node_topics.MARKERS}
CLAIMED = {node_topics.TARGET, node_topics.BOX}


def makers_of(estimate, particles=None):
    return target_messages(
        FACTORY, HEADER, estimate, particles, ms=3.5, metres=lambda: {"range": "2.5"}
    )


@pytest.mark.parametrize(
    ("estimate", "particles", "more"),
    [
        (ESTIMATE, PARTICLES, CLAIMED | {node_topics.CONTOUR, node_topics.PARTICLES}),
        (replace(ESTIMATE, outline=np.empty((0, 2))), None, CLAIMED),
        (replace(ESTIMATE, status=TrackingStatus.LOST), None, set()),
        (replace(ESTIMATE, box=None), None, set()),
    ],
)
def test_each_message_that_there_is_has_the_type_of_its_topic(estimate, particles, more):
    makers = makers_of(estimate, particles)
    assert set(makers) == ALWAYS | more
    assert all(make().__msgtype__ == topic.type_name for topic, make in makers.items())


def test_the_report_holds_time_particles_and_metres():
    facts = report_facts(makers_of(ESTIMATE, PARTICLES)[node_topics.TARGET_REPORT]())
    assert (facts["ms"], facts["particles"], facts["range"]) == ("3.5", "5", "2.5")


def test_a_refused_frame_has_an_empty_state_and_a_reason():
    makers = messages_without_target(FACTORY, HEADER, "REFUSED", "too small")
    assert len(makers[node_topics.STATE]().position) == 0
    report = makers[node_topics.TARGET_REPORT]()
    assert (report_status(report), report_facts(report)) == ("REFUSED", {"event": "too small"})
