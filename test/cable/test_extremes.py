"""Presets `default` and `thesis` at the limits.

A cable outside, wider than the image, across it, at the wrap of alpha.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from plain_images import plain_image
from sound_estimates import assert_sound

from cable_tracker.cable.model.geometry import project_borders, wrap_states
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, WIDTH, CableState
from cable_tracker.cable.model.statistics import cable_mean_and_covariance
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import PRESETS, preset
from cable_tracker.cable.thesis.border_response_model import BorderResponseModel
from cable_tracker.cable.thesis.movement import LimitedMovement
from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.particles import normalise_log_weights
from cable_tracker.trackers import CableTracker

SIZE = (96, 72)
STEP = 40_000_000
PARTICLES = 60
RIGHT = math.pi / 2
BETA_LIMIT = math.radians(20.0)

PLACES = {
    "outside to the left": CableState(-5000.0, 0.0, 20.0),
    "outside, far": CableState(1e9, 0.3, 20.0),
    "wider than the image": CableState(0.0, 0.1, 5000.0),
    "without width": CableState(0.0, 0.1, 1e-300),
    "beta at its limit": CableState(0.0, 0.0, 20.0, BETA_LIMIT),
    "beta at its other limit": CableState(0.0, 0.0, 20.0, -BETA_LIMIT),
    "beta at a right angle": CableState(0.0, 0.0, 20.0, RIGHT),
    "across the image": CableState(0.0, RIGHT, 20.0),
    "across, from the other side": CableState(0.0, -RIGHT + 1e-12, 20.0),
    "many turns": CableState(3.0, 1e6, 20.0),
    "very fast": CableState(0.0, 0.0, 20.0, 0.0, 1e12, 1e12, 1e12, 1e12),
}


def draw_cable(angle: float = 0.0) -> np.ndarray:
    x = np.arange(SIZE[0]) - (SIZE[0] - 1) / 2
    y = (SIZE[1] - 1) / 2 - np.arange(SIZE[1])
    across = x[None, :] * math.cos(angle) + y[:, None] * math.sin(angle)
    return np.where(np.abs(across) <= 10.0, 180, 60).astype(np.uint8)


PICTURES = {
    "black": np.zeros(SIZE[::-1], np.uint8),
    "white": np.full(SIZE[::-1], 255, np.uint8),
    "a cable": draw_cable(),
    "a cable across": draw_cable(angle=RIGHT),
    "noise": np.random.default_rng(3).integers(0, 256, SIZE[::-1], dtype=np.uint8),
    "tiny numbers": np.full(SIZE[::-1], 1e-300, np.float32),
}


def stamps() -> Iterator[int]:
    stamp = 1_000_000_000
    while True:
        yield stamp
        stamp += STEP


@pytest.fixture(params=sorted(PRESETS))
def parameters(request: pytest.FixtureRequest) -> TrackerParameters:
    return preset(request.param).replaced({"particle_count": PARTICLES, "seed": 5})


@pytest.mark.parametrize("state", PLACES.values(), ids=PLACES)
def test_wherever_the_cable_is_believed_to_be_the_estimate_is_sound(parameters, state):
    for picture in PICTURES.values():
        tracker = CableTracker(parameters)
        tracker.initialise(GivenState.around(state))
        for _, stamp in zip(range(4), stamps(), strict=False):
            assert_sound(tracker.process(picture, stamp))


@pytest.mark.parametrize("name", sorted(PRESETS))
@given(
    picture=arrays(np.uint8, st.tuples(st.integers(2, 40), st.integers(2, 40)))
    | arrays(np.float32, (20, 30), elements=st.floats(0, 255, width=32)),
    gaps=st.lists(st.integers(-(10**10), 10**11), min_size=1, max_size=5),
)
@settings(max_examples=20, suppress_health_check=[HealthCheck.too_slow])
def test_any_picture_at_any_time_is_answered_or_refused(name, picture, gaps):
    tracker = CableTracker(preset(name).replaced({"particle_count": PARTICLES}))
    stamp = 10**12
    for gap in gaps:
        stamp += gap
        try:
            assert_sound(tracker.process(picture, stamp))
        except FrameError as error:
            assert str(error)


@given(
    arrays(
        np.float64,
        (12, 8),
        elements=st.floats(-1e6, 1e6) | st.sampled_from([RIGHT, -RIGHT, math.pi, 0.0]),
    ),
    arrays(np.float64, (12,), elements=st.floats(allow_nan=True) | st.just(-math.inf)),
)
def test_mean_and_covariance_of_any_cables_are_sound(states, log_weights):
    weights = np.exp(normalise_log_weights(log_weights).log_weights)
    mean, covariance = cable_mean_and_covariance(states, weights)
    assert np.isfinite(mean).all()
    assert -RIGHT < mean[ANGLE] <= RIGHT
    assert np.isfinite(covariance).all()
    eigenvalues = np.linalg.eigvalsh(covariance)
    assert eigenvalues.min() >= -1e-9 * max(eigenvalues.max(), 1.0)


@pytest.mark.parametrize("name", sorted(PRESETS))
@given(
    arrays(np.float64, (9, 8), elements=st.floats(-1e9, 1e9)),
    st.floats(1e-9, 3600.0),
    st.integers(0, 99),
)
def test_particles_stay_within_their_limits(name, states, dt, seed):
    parameters = preset(name)
    moved = LimitedMovement(parameters, 320).propagate(states, dt, np.random.default_rng(seed))
    assert np.isfinite(moved).all()
    angles = moved[:, ANGLE]
    assert ((angles > -RIGHT) & (angles <= RIGHT)).all()
    assert (np.abs(moved[:, DISTANCE]) <= parameters.distance_limit).all()
    widths = moved[:, WIDTH]
    assert ((widths >= parameters.width_minimum) & (widths <= parameters.width_maximum)).all()
    assert (np.abs(moved[:, SKEW]) <= math.radians(parameters.skew_limit)).all()


@given(arrays(np.float64, (9, 8), elements=st.floats(-1e9, 1e9)))
def test_the_likelihood_of_any_cable_is_a_number(states):
    image = plain_image(draw_cable())
    likelihoods = BorderResponseModel(preset("thesis")).log_likelihoods(wrap_states(states), image)
    assert np.isfinite(likelihoods).all()
    assert np.isfinite(project_borders(states).offsets).all()
