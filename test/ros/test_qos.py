from __future__ import annotations

import pytest
from rclpy.qos import (
    DurabilityPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)

from cable_tracker.ros import qos


@pytest.mark.parametrize("reliability", qos.RELIABILITIES)
def test_the_tracker_can_read_what_the_replay_sends(reliability: str) -> None:
    compatible, reason = qos_check_compatible(qos.PICTURES, qos.image_input(reliability))
    assert compatible is not QoSCompatibility.ERROR, reason


def test_a_best_effort_camera_can_be_read_by_default() -> None:
    camera = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
    compatible, _ = qos_check_compatible(camera, qos.image_input("best_effort"))
    assert compatible is not QoSCompatibility.ERROR


def test_best_effort_takes_the_newest_frame_and_reliable_keeps_some() -> None:
    assert qos.image_input("best_effort").depth == 1
    assert qos.image_input("reliable").depth > 1


def test_a_lockstep_replay_hears_answers_from_before_it_was_discovered() -> None:
    assert qos.NEWEST_RESULT.durability is DurabilityPolicy.TRANSIENT_LOCAL
    compatible, reason = qos_check_compatible(qos.LATEST_RESULT, qos.NEWEST_RESULT)
    assert compatible is not QoSCompatibility.ERROR, reason
