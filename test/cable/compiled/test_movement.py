import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.compiled.bootstrap_filter import predict
from cable_tracker.cable.compiled.movement import BLOCK, NOTHING
from cable_tracker.cable.model.initialisation import random_states
from cable_tracker.cable.model.movement import (
    CableMovement,
    effective_time,
    rate_damping_over,
    state_limits,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.particle_filter.normal import uniform_rows
from cable_tracker.particle_filter.student_t import student_t_stretches

MODELS = {
    "thesis": preset("thesis"),
    "heavy tails": TrackerParameters(filter="bootstrap"),
    "one component": preset("thesis").replaced(
        dict.fromkeys(
            ("distance_variance", "angle_variance", "skew_variance", "distance_rate_variance",
             "angle_rate_variance"), 0.0,
        )
    ),
}  # fmt: skip


def moved(parameters, states, ancestors, dt, seed):
    """Move columns as the compiled filter does."""
    movement, rng = CableMovement(parameters, 320), np.random.default_rng(seed)
    limits, sigmas = state_limits(parameters, 320), movement.diffusion_sigmas(dt)
    count = len(ancestors) or len(states)
    pairs = uniform_rows(int(np.count_nonzero(sigmas)))
    still = ((sigmas[4:] == 0.0) & (states[:, 4:] == 0.0).all(axis=0)).astype(float)
    after = np.zeros((8, count))
    predict(
        np.ascontiguousarray(states.T),
        ancestors,
        still,
        effective_time(parameters, dt),
        rate_damping_over(parameters, dt),
        rng.random((pairs, count)),
        np.empty((2 * pairs, BLOCK), np.float32),
        student_t_stretches(rng, 2, count, movement.degrees_of_freedom),
        sigmas,
        limits.lower,
        limits.upper,
        parameters.limit_handling == "reflect",
        after,
    )
    return after.T


@pytest.mark.parametrize("resampled", [False, True])
@pytest.mark.parametrize("model", MODELS)
@given(count=st.integers(1, 2 * BLOCK), dt=st.floats(0.001, 2.0), seed=st.integers(0, 2**31))
def test_the_same_movement_as_numpy(model, resampled, count, dt, seed):
    parameters = MODELS[model].replaced({"particle_count": count})
    rng = np.random.default_rng(seed)
    states = random_states(parameters, 320, rng)
    ancestors = np.sort(rng.integers(0, count, count)) if resampled else NOTHING
    expected = CableMovement(parameters, 320).propagate(
        states[ancestors] if resampled else states, dt, np.random.default_rng(seed)
    )
    found = moved(parameters, states, ancestors, dt, seed)
    # A number next to the wrap or a limit may fall on its other side.
    scale = 1.0 + np.abs(expected) + 10.0 * CableMovement(parameters, 320).diffusion_sigmas(dt)
    same = (np.abs(found - expected) < 1e-4 * scale).all(axis=1)
    assert (~same).sum() <= 1
