from __future__ import annotations

from dataclasses import replace

import numpy as np

from cable_tracker.offline.target_table import TargetRow, row_of
from cable_tracker.ros.clients.message_rows import target_row
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.target import make_target_state, target_report_values
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.tracking.status import TrackingStatus

FRAME = Frame(3, 1_700_000_000_040_000_000, raw_from_array(np.zeros((2, 2), np.uint8), "mono8"))
ESTIMATE = TargetEstimate(
    stamp=FRAME.stamp,
    status=TrackingStatus.TRACKING,
    image_size=(320, 240),
    state=np.array([12.5, -3.25, 0.3, 0.1, 4.0, -1.0]),
    covariance=np.diag(np.arange(1.0, 7.0) / 3),
    box=(100.0, 50.0, 140.5, 90.25),
    area=1234.5,
    presence=2 / 3,
    effective_sample_size=100 / 3,
)


def row_over_ros(estimate: TargetEstimate) -> TargetRow:
    """Return the row that is made of the node's messages."""
    state = make_target_state(MESSAGES, make_header(MESSAGES, FRAME.stamp, "camera"), estimate)
    facts = target_report_values(estimate, 1.25, 200)
    return target_row(FRAME.index, FRAME.stamp, estimate.status.value, state, facts)


def test_the_row_of_a_target_is_the_one_made_without_ros() -> None:
    found, wanted = row_over_ros(ESTIMATE), row_of(FRAME, ESTIMATE, 1.25)
    assert found.claim is not None
    assert found == wanted
    assert found.cells() == wanted.cells()


def test_without_a_claim_it_has_none() -> None:
    lost = replace(ESTIMATE, status=TrackingStatus.LOST)
    assert row_over_ros(lost) == row_of(FRAME, lost, 1.25)
    assert row_over_ros(lost).claim is None
