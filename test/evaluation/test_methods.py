from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.arrays import Image
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.errors import is_off_cable, state_errors
from cable_tracker.evaluation.methods import METHODS
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate
from cable_tracker.tracking.status import TrackingStatus

DETECTORS = ("hough", "segmentation", "lsd", "texture")


@pytest.fixture(scope="module")
def easy_dive() -> list[tuple[Image, int, CableState]]:
    settings = SimulationSettings(frame_count=30, clutter=0.2, seed=31)
    return [
        (decode_grey(frame.image), frame.stamp, frame.truth)
        for frame in simulate(settings)
        if frame.truth is not None
    ]


def track(name: str, dive, *, seed=0, from_truth=True):
    method = METHODS[name].make(seed)
    if from_truth:
        method.initialise(GivenState.around(dive[0][2].at_rest()))
    return [method.process(image, stamp) for image, stamp, _ in dive]


def share_lost(estimates, dive) -> float:
    truths = [truth for _, _, truth in dive]
    pairs = list(zip(estimates, truths, strict=True))
    silent = np.array([each.status is not TrackingStatus.TRACKING for each in estimates])
    errors = np.array([state_errors(each.state, truth) for each, truth in pairs])
    off = is_off_cable(errors, np.array([truth.width for truth in truths]), forgiven=0.0)
    return float(np.mean(silent | off))


def test_the_methods_are_those_that_are_compared():
    assert list(METHODS) == ["default", "thesis", *DETECTORS]
    assert all(spec.name == name and spec.description for name, spec in METHODS.items())


@pytest.mark.parametrize("name", METHODS)
def test_an_easy_dive_is_followed_from_the_truth(name, easy_dive):
    assert share_lost(track(name, easy_dive), easy_dive) < 0.2


@pytest.mark.parametrize("name", DETECTORS)
def test_detectors_find_the_cable_of_an_easy_dive_by_themselves(name, easy_dive):
    estimates = track(name, easy_dive, from_truth=False)
    assert share_lost(estimates, easy_dive) < 0.2
    assert estimates[0].status is TrackingStatus.INITIALISING


@pytest.mark.parametrize("name", METHODS)
def test_the_same_seed_gives_the_same_estimates(name, easy_dive):
    first, second = (track(name, easy_dive[:5], seed=3) for _ in range(2))
    assert [estimate.state for estimate in first] == [estimate.state for estimate in second]
    np.testing.assert_array_equal(first[-1].covariance, second[-1].covariance)


@pytest.mark.parametrize("name", ["default", "thesis"])
def test_another_seed_gives_other_particles(name, easy_dive):
    first, second = (track(name, easy_dive[:3], seed=seed)[-1].state for seed in (1, 2))
    assert first != second


@pytest.mark.parametrize("name", METHODS)
def test_noise_without_a_cable_is_not_claimed(name):
    rng = np.random.default_rng(5)
    method = METHODS[name].make(0)
    for index in range(12):
        image = rng.normal(110.0, 12.0, (240, 320)).astype(np.uint8)
        assert method.process(image, 10**9 + 40_000_000 * index).status is not (
            TrackingStatus.TRACKING
        )


@pytest.mark.parametrize("name", DETECTORS)
def test_a_strip_that_turns_through_the_wrap_is_followed(draw_strip, name):
    method = METHODS[name].make(0)
    for index, degrees in enumerate(np.arange(80.0, 101.0)):
        state = CableState(15.0, np.deg2rad(degrees), 30.0)
        estimate = method.process(
            draw_strip(state, strip=180, ground=70), 10**9 + 40_000_000 * index
        )
    assert estimate.status is TrackingStatus.TRACKING
    errors = np.abs(state_errors(estimate.state, state))
    assert errors[0] < 2.0
    assert errors[1] < np.deg2rad(1.0)
