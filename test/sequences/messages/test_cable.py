from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from message_parts import FACTORY, HEADER

from cable_tracker.cable.model.estimate import CableEstimate, Hypothesis
from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.cable import (
    cable_messages,
    centreline_covariance,
    cloud_of,
    make_centreline,
    make_markers,
    make_particles,
    make_state,
    messages_without_cable,
    read_particles,
    read_prior,
    read_sigma,
    read_state,
    report_values,
)
from cable_tracker.sequences.messages.frame_report import make_report, report_facts, report_status
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE, make_stamped_pose
from cable_tracker.tracking.status import TrackingStatus

STATE = CableState(12.5, 0.3, 40.0, 0.02, -7.0, 0.05, 3.0, -0.01)
SIZE = (320, 240)
COVARIANCE = np.diag([4.0, 0.01, 9.0, 0.001, 25.0, 0.1, 4.0, 0.02])
COVARIANCE[0, 1] = COVARIANCE[1, 0] = 0.05
ANGLES = st.floats(-math.pi / 2 + 1e-6, math.pi / 2)


def test_a_state_is_kept_exactly_with_its_sigma(sent):
    message = sent(make_state(FACTORY, HEADER, STATE, [1.0, 0.1, 2.0, 0.01]))
    assert list(message.name) == ["d", "alpha", "w", "beta"]
    assert list(message.velocity) == [-7.0, 0.05, 3.0, -0.01]
    assert read_state(message) == STATE
    assert read_sigma(message) == (1.0, 0.1, 2.0, 0.01)


def test_no_cable_means_no_numbers(sent):
    message = sent(make_state(FACTORY, HEADER, None, [1.0, 0.1, 2.0, 0.01]))
    assert len(message.position) == len(message.velocity) == len(message.effort) == 0
    assert read_state(message) is None
    assert read_sigma(message) is None


def test_a_state_of_another_sender_may_have_another_order_and_no_rates():
    message = FACTORY.make(
        "sensor_msgs/msg/JointState",
        name=["w", "extra", "d", "beta", "alpha"],
        position=FACTORY.doubles([30.0, 9.0, 1.0, 0.1, 0.2]),
    )
    assert read_state(message) == CableState(1.0, 0.2, 30.0, 0.1)


def test_rates_are_read_by_their_names_too():
    message = FACTORY.make(
        "sensor_msgs/msg/JointState",
        name=["beta", "w", "d", "alpha"],
        position=FACTORY.doubles([0.1, 30.0, 1.0, 0.2]),
        velocity=FACTORY.doubles([0.01, 3.0, -7.0, 0.05]),
    )
    assert read_state(message) == CableState(1.0, 0.2, 30.0, 0.1, -7.0, 0.05, 3.0, 0.01)


@pytest.mark.parametrize(
    ("names", "positions"), [(["a", "b"], [1.0, 2.0]), (["d", "alpha", "w", "beta"], [1.0, 2.0])]
)
def test_a_state_whose_names_and_numbers_do_not_belong_together_is_refused(names, positions):
    message = FACTORY.make(
        "sensor_msgs/msg/JointState", name=names, position=FACTORY.doubles(positions)
    )
    with pytest.raises(FrameError) as caught:
        read_state(message)
    assert "\n" not in str(caught.value)


def test_the_centreline_is_the_foot_point_with_the_angle(sent):
    message = sent(make_centreline(FACTORY, HEADER, STATE, COVARIANCE))
    pose = message.pose.pose
    assert pose.position.x == pytest.approx(12.5 * math.cos(0.3))
    assert pose.position.y == pytest.approx(12.5 * math.sin(0.3))
    assert 2 * math.atan2(pose.orientation.z, pose.orientation.w) == pytest.approx(0.3)
    assert message.pose.covariance[35] == pytest.approx(0.01)
    assert stamp_of(message.header) == 1_700_000_000_123_456_789


def test_the_covariance_of_the_foot_point_is_that_of_its_samples():
    rng = np.random.default_rng(0)
    small = COVARIANCE[:2, :2] * 1e-4
    d, alpha = rng.multivariate_normal([12.5, 0.3], small, 200_000).T
    sampled = np.cov(np.stack((d * np.cos(alpha), d * np.sin(alpha), alpha)))
    scaled = centreline_covariance(STATE, COVARIANCE * 1e-4)
    np.testing.assert_allclose(
        scaled[np.ix_([0, 1, 5], [0, 1, 5])], sampled, rtol=0.05, atol=0.03 * sampled.max()
    )


def test_unknown_components_are_large_finite_and_uncorrelated():
    covariance = centreline_covariance(STATE, COVARIANCE)
    np.testing.assert_array_equal(covariance, covariance.T)
    for axis in (2, 3, 4):
        expected = np.zeros(6)
        expected[axis] = UNKNOWN_VARIANCE
        np.testing.assert_array_equal(covariance[axis], expected)
    assert np.linalg.eigvalsh(covariance).min() > -1e-9


@given(st.floats(-200, 200), ANGLES, st.floats(1e-3, 100), st.floats(1e-6, 1))
def test_a_centreline_is_read_back_as_a_prior(distance, angle, var_d, var_angle):
    covariance = np.diag([var_d, var_angle, 1.0, 1.0, 1.0, 1.0])
    state = CableState(distance, angle, 30.0)
    prior = read_prior(make_centreline(FACTORY, HEADER, state, covariance))
    found = wrap_states(prior.state.to_array()[None])[0]
    assert found[0] == pytest.approx(distance, abs=1e-6)
    assert found[1] == pytest.approx(angle, abs=1e-9)
    np.testing.assert_allclose(prior.sigma[:2] ** 2, [var_d, var_angle], rtol=1e-3)
    assert np.isinf(prior.sigma[2:]).all()


@pytest.mark.parametrize("length", [0.92, 1.08])
def test_a_prior_is_read_alike_whatever_the_length_of_its_quaternion(length):
    message = make_centreline(FACTORY, HEADER, CableState(0.0, 1.4, 30.0), COVARIANCE)
    message.pose.pose.orientation.z *= length
    message.pose.pose.orientation.w *= length
    assert read_prior(message).state.angle == pytest.approx(1.4)


def pose_message(**covariances: float):
    message = make_centreline(FACTORY, HEADER, STATE, COVARIANCE)
    message.pose.covariance[:] = 0.0
    for entry, value in covariances.items():
        message.pose.covariance[int(entry[1:])] = value
    return message


def test_a_prior_without_variances_leaves_them_unsaid():
    assert np.isnan(read_prior(pose_message()).sigma[:2]).all()


def test_a_prior_of_unknown_variance_is_not_known():
    prior = read_prior(pose_message(_0=1e6, _7=1e6, _35=0.04))
    assert prior.sigma[:2] == pytest.approx([np.inf, 0.2])


def test_a_position_that_is_not_known_is_so_in_every_direction():
    covariance = np.diag([UNKNOWN_VARIANCE] * 5 + [0.01])
    messages = [
        make_stamped_pose(FACTORY, HEADER, (0.0, 0.0, 0.0), math.radians(degrees), covariance)
        for degrees in range(-180, 181)
    ]
    assert all(np.isinf(read_prior(message).sigma[0]) for message in messages)


def prior_of(position, degrees, *, x, y, yaw):
    """The prior of a position and a direction with these variances."""
    covariance = np.diag([x, y, 1e6, 1e6, 1e6, yaw])
    message = make_stamped_pose(
        FACTORY, HEADER, (*position, 0.0), math.radians(degrees), covariance
    )
    return read_prior(message)


@pytest.mark.parametrize("degrees", [30, 45, -60, 90, 150])
def test_a_line_across_what_is_not_known_has_no_distance(degrees):
    prior = prior_of((30.0, 0.0), degrees, x=4.0, y=1e6, yaw=0.003)
    assert np.isinf(prior.sigma[0])
    assert prior.sigma[1] == pytest.approx(math.sqrt(0.003))
    assert prior.point is None


@pytest.mark.parametrize(("degrees", "x", "y"), [(0, 4.0, 1e6), (180, 4.0, 1e6), (90, 1e6, 4.0)])
def test_a_position_along_the_line_need_not_be_known(degrees, x, y):
    prior = prior_of((30.0, 30.0), degrees, x=x, y=y, yaw=0.003)
    assert prior.sigma[0] == pytest.approx(2.0)


@pytest.mark.parametrize("degrees", [0, 40, -40])
def test_a_position_without_a_direction_is_a_point_and_no_distance(degrees):
    prior = prior_of((0.0, 90.0), degrees, x=3.0, y=5.0, yaw=1e6)
    assert np.isinf(prior.sigma).all()
    assert prior.point == (0.0, 90.0, 2.0)
    assert prior.describe() == "through x 0.0 px, y 90.0 px"


def test_without_a_direction_half_a_position_is_nothing():
    prior = prior_of((0.0, 90.0), 0, x=4.0, y=1e6, yaw=1e6)
    assert np.isinf(prior.sigma).all()
    assert prior.point is None
    assert prior.describe() == "nothing is known"


@pytest.mark.parametrize(
    "spoil",
    [
        lambda m: setattr(m.pose.pose.position, "x", math.nan),
        lambda m: setattr(m.pose.pose.position, "y", math.inf),
        lambda m: setattr(m.pose.pose.orientation, "z", math.nan),
        lambda m: setattr(m.pose.pose.orientation, "w", 0.0),
        lambda m: m.pose.covariance.__setitem__(0, math.nan),
        lambda m: m.pose.covariance.__setitem__(35, -1.0),
        lambda m: m.pose.covariance.__setitem__(slice(None), -math.inf),
    ],
    ids=["nan x", "inf y", "nan z", "no quaternion", "nan variance", "negative", "all -inf"],
)
def test_a_prior_that_makes_no_sense_is_refused_in_one_line(spoil):
    message = make_centreline(FACTORY, HEADER, CableState(12.5, 0.3, 40.0), COVARIANCE)
    spoil(message)
    with pytest.raises(FrameError) as caught:
        read_prior(message)
    assert "\n" not in str(caught.value)


def test_a_report_holds_status_and_facts(sent):
    estimate = CableEstimate(
        stamp=1,
        status=TrackingStatus.LOST,
        state=STATE,
        covariance=COVARIANCE,
        effective_sample_size=123.5,
        evidence=0.25,
        image_size=SIZE,
        event="time went back by 1.000 s",
        presence=0.0625,
        hypotheses=(Hypothesis(0.91, STATE), Hypothesis(0.0804, STATE)),
    )
    report = sent(make_report(FACTORY, HEADER, "LOST", report_values(estimate, 1.5))).status[0]
    assert (report.message, report.hardware_id) == ("LOST", "camera")
    assert {pair.key: pair.value for pair in report.values} == {
        "n_eff": "123.5",
        "ms": "1.5",
        "evidence": "0.25",
        "presence": "0.0625",
        "hypotheses": "0.910 0.080",
        "event": "time went back by 1.000 s",
    }


def test_values_that_a_filter_does_not_have_are_empty_in_the_report():
    estimate = CableEstimate(1, TrackingStatus.LOST, STATE, COVARIANCE, 1.0, 0.0, SIZE)
    values = report_values(estimate, 1.5)
    assert values["presence"] == values["hypotheses"] == values["event"] == ""


def test_particles_are_kept_as_float32(sent):
    states = np.random.default_rng(0).normal(size=(50, 8))
    cloud = cloud_of(Particles.equally_weighted(states))
    message = sent(make_particles(FACTORY, HEADER, cloud))
    np.testing.assert_allclose(read_particles(message), cloud, rtol=1e-6)
    assert [field.name for field in message.fields] == [
        "x", "y", "z", "d", "alpha", "w", "beta", "v_d", "v_alpha", "v_w", "v_beta", "weight",
    ]  # fmt: skip
    assert (message.width, message.point_step, message.row_step) == (50, 48, 2400)
    points = np.frombuffer(message.data, "<f4").reshape(50, 12)
    np.testing.assert_allclose(points[:, 0], states[:, 0] * np.cos(states[:, 1]), rtol=1e-5)
    np.testing.assert_allclose(points[:, 1], states[:, 0] * np.sin(states[:, 1]), rtol=1e-5)


def test_markers_show_borders_and_centreline_in_metres(sent):
    markers = sent(make_markers(FACTORY, HEADER, CableState(20.0, 0.0, 40.0), SIZE)).markers
    clear, image, borders, centreline = markers
    assert clear.action == 3
    assert [m.ns for m in (image, borders, centreline)] == ["image", "borders", "centreline"]
    assert len(image.points) == 8
    assert [p.x for p in centreline.points] == pytest.approx([0.2, 0.2])
    assert [p.y for p in centreline.points] == pytest.approx([-1.195, 1.195])
    assert [p.x for p in borders.points] == pytest.approx([0.0, 0.0, 0.4, 0.4])


def test_without_a_cable_earlier_markers_are_deleted():
    markers = make_markers(FACTORY, HEADER, None, SIZE).markers
    assert [m.ns for m in markers] == ["", "image"]


def test_a_cable_outside_the_image_has_markers_without_points(sent):
    markers = sent(make_markers(FACTORY, HEADER, CableState(500.0, 0.0, 40.0), SIZE)).markers
    assert [len(m.points) for m in markers[2:]] == [0, 0]


POSE = CableState(12.5, 0.3, 40.0, 0.02)
ESTIMATE = CableEstimate(
    stamp=1_700_000_000_123_456_789,
    status=TrackingStatus.TRACKING,
    image_size=(320, 240),
    state=POSE,
    covariance=np.diag([4.0, 0.01, 9.0, 0.0001, 1.0, 1.0, 1.0, 1.0]),
    hypotheses=(),
    effective_sample_size=5.0,
    evidence=1.0,
)
PARTICLES = Particles(np.zeros((5, 8)), np.full(5, 0.2))


def makers_of(estimate, particles=PARTICLES):
    return cable_messages(
        FACTORY, HEADER, estimate, particles, ms=3.5, metres=lambda: {"offset": "0.5"}
    )


def test_each_message_of_a_claimed_cable_has_the_type_of_its_topic():
    makers = makers_of(ESTIMATE)
    assert set(makers) == {
        node_topics.STATE,
        node_topics.FRAME_REPORT,
        node_topics.CENTRELINE,
        node_topics.PARTICLES,
        node_topics.MARKERS,
    }
    assert all(make().__msgtype__ == topic.type_name for topic, make in makers.items())
    state = makers[node_topics.STATE]()
    assert read_state(state) == POSE
    assert read_sigma(state) == (2.0, 0.1, 3.0, 0.01)


def test_a_cable_that_is_not_claimed_has_no_centreline():
    makers = makers_of(replace(ESTIMATE, status=TrackingStatus.LOST))
    assert node_topics.CENTRELINE not in makers
    assert read_state(makers[node_topics.STATE]()) is None


def test_without_particles_there_is_no_message_of_them():
    assert node_topics.PARTICLES not in makers_of(ESTIMATE, None)


def test_metres_are_asked_for_when_the_report_is_made():
    asked = []
    makers = cable_messages(
        FACTORY, HEADER, ESTIMATE, None, ms=3.5, metres=lambda: asked.append(1) or {"offset": "0.5"}
    )
    assert asked == []
    facts = report_facts(makers[node_topics.FRAME_REPORT]())
    assert (facts["ms"], facts["offset"]) == ("3.5", "0.5")
    assert asked == [1]


def test_a_refused_frame_has_an_empty_state_and_a_reason():
    makers = messages_without_cable(FACTORY, HEADER, "REFUSED", "too small")
    assert read_state(makers[node_topics.STATE]()) is None
    report = makers[node_topics.FRAME_REPORT]()
    assert (report_status(report), report_facts(report)) == ("REFUSED", {"event": "too small"})
