from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.belief import initial_belief


def test_states_that_are_given_count_alike_and_are_wrapped(rng):
    states = np.array([20.0, np.pi / 2, 30.0, 0.0, 0.0, 0.0, 0.0, 0.0]) + rng.normal(
        0.0, 0.01, (50, 8)
    )
    belief = initial_belief(states, 0.9, 320)
    assert belief.presence == 0.9
    np.testing.assert_allclose(belief.particles.weights, 1 / 50)
    assert (np.abs(belief.particles.states[:, 1]) <= np.pi / 2).all()
    # One cloud on both sides of the wrap: its middle is not upright.
    assert len(belief.clusters) == 1
    assert abs(belief.reference_angle) == pytest.approx(np.pi / 2, abs=0.01)
    assert belief.memory is None
    assert belief.usual_width is None
