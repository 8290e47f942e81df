"""Factory, header and a tracked target for tests of messages."""

from __future__ import annotations

import numpy as np

from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.tracking.status import TrackingStatus

FACTORY = RosbagsMessages()
HEADER = make_header(FACTORY, 1_700_000_000_123_456_789, "camera")
ESTIMATE = TargetEstimate(
    stamp=5,
    status=TrackingStatus.TRACKING,
    image_size=(320, 240),
    state=np.array([12.0, -8.0, 0.0, 0.3, 2.0, -1.0]),
    covariance=np.diag([4.0, 9.0, 0.01, 0.04, 1.0, 1.0]),
    box=(150.0, 100.0, 190.0, 140.0),
    outline=np.array([[150.0, 100.0], [190.0, 100.0], [170.0, 140.0]]),
    area=1600.0,
)
