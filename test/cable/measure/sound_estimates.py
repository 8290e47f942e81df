"""What is promised of every estimate of a cable."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.cable.model.estimate import CableEstimate


def assert_sound(estimate: CableEstimate, count: float = math.inf) -> None:
    """Hold an estimate by `count` particles against what is promised."""
    assert estimate.state.is_finite()
    assert -math.pi / 2 < estimate.state.angle <= math.pi / 2
    assert np.isfinite(estimate.covariance).all()
    assert (estimate.covariance == estimate.covariance.T).all()
    eigenvalues = np.linalg.eigvalsh(estimate.covariance)
    assert eigenvalues.min() >= -1e-9 * max(eigenvalues.max(), 1.0)
    assert np.isfinite(estimate.standard_deviations()).all()
    assert math.isfinite(estimate.evidence)
    assert 1.0 <= estimate.effective_sample_size <= count
    assert estimate.presence is None or 0.0 <= estimate.presence <= 1.0
    for hypothesis in estimate.hypotheses:
        assert hypothesis.state.is_finite()
