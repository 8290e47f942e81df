from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.state import CableState
from cable_tracker.tracking.status import TrackingStatus


def an_estimate(status: TrackingStatus, covariance: FloatArray) -> CableEstimate:
    return CableEstimate(
        stamp=0,
        status=status,
        state=CableState(0.0, 0.0, 30.0),
        covariance=covariance,
        effective_sample_size=1.0,
        evidence=1.0,
        image_size=(320, 240),
    )


def test_standard_deviations_are_roots_and_never_nan():
    covariance = np.diag([4.0, 0.25, 9.0, 0.0, -1e-18, 1.0])
    estimate = an_estimate(TrackingStatus.TRACKING, covariance)
    np.testing.assert_array_equal(estimate.standard_deviations(), [2.0, 0.5, 3.0, 0.0, 0.0, 1.0])
    assert estimate.event == ""


@pytest.mark.parametrize("status", TrackingStatus)
def test_only_a_cable_that_is_tracked_is_claimed(status):
    estimate = an_estimate(status, np.eye(8))
    assert estimate.is_claimed == (status is TrackingStatus.TRACKING)
    assert estimate.claimed_state == (estimate.state if estimate.is_claimed else None)
