from __future__ import annotations

import numpy as np

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.state import CableState
from cable_tracker.tracking.status import TrackingStatus


def test_standard_deviations_are_roots_and_never_nan():
    covariance = np.diag([4.0, 0.25, 9.0, 0.0, -1e-18, 1.0])
    estimate = CableEstimate(
        stamp=0,
        status=TrackingStatus.TRACKING,
        state=CableState(0.0, 0.0, 30.0),
        covariance=covariance,
        effective_sample_size=1.0,
        evidence=1.0,
        image_size=(320, 240),
    )
    np.testing.assert_array_equal(estimate.standard_deviations(), [2.0, 0.5, 3.0, 0.0, 0.0, 1.0])
    assert estimate.event == ""
