import math

import numpy as np
import pytest

from cable_tracker.metric.targets.relative_state import (
    RelativeNoise,
    TargetSighting,
    begin_relative_state,
)

DT = 0.04
SIZE = 0.5


def sighting(bearing, distance, rng=None, bias=0.0, is_whole=True):
    noise = rng.standard_normal(3) if rng is not None else np.zeros(3)
    size = SIZE / distance * math.exp(bias + 0.03 * noise[2])
    return TargetSighting(
        bearing + math.radians(0.6) * noise[0], math.radians(0.6) * noise[1], size, is_whole
    )


def followed(seed, bias):
    """A target that swims away and comes back; errors and whether truth is within two sigmas."""
    rng = np.random.default_rng(seed)
    state = begin_relative_state(sighting(0.1, 5.0, rng, bias), SIZE)
    ranges, bearings, within = [], [], []
    for number in range(1, 500):
        time = number * DT
        distance = 5.0 + 2.0 * math.sin(0.3 * time)
        bearing = 0.1 + 0.2 * math.sin(0.4 * time)
        state = state.predicted(DT).updated(sighting(bearing, distance, rng, bias))
        ranges.append(abs(state.range / distance - 1.0))
        bearings.append(abs(state.mean[0] - bearing))
        within.append(abs(state.range - distance) < 2.0 * state.range_sigma)
    return np.median(ranges), np.median(bearings), np.mean(within)


def test_range_and_bearing_are_good_and_honest_though_sizes_are_biased():
    biases = np.random.default_rng(9).normal(0.0, 0.05, 12)
    figures = np.array([followed(seed, bias) for seed, bias in enumerate(biases)])
    assert np.median(figures[:, 0]) < 0.08
    assert np.median(figures[:, 1]) < math.radians(1.0)
    assert 0.8 <= figures[:, 2].mean() <= 1.0


def test_without_a_bias_it_would_be_too_sure():
    state = begin_relative_state(sighting(0.0, 5.0), SIZE)
    sure = begin_relative_state(sighting(0.0, 5.0), SIZE, RelativeNoise(bias_sigma=1e-6))
    for _ in range(100):
        state, sure = (each.predicted(DT).updated(sighting(0.0, 5.0)) for each in (state, sure))
    assert state.range_sigma > 0.7 * 0.05 * 5.0
    assert sure.range_sigma < 0.3 * 0.05 * 5.0


def test_sizes_of_targets_that_are_not_whole_do_not_count():
    state = begin_relative_state(sighting(0.0, 5.0), SIZE)
    for _ in range(20):
        state = state.predicted(DT).updated(sighting(0.0, 20.0, is_whole=False))
    assert state.range == pytest.approx(5.0, rel=0.02)


def test_the_gate_refuses_jumps_and_opens_again():
    state = begin_relative_state(sighting(0.0, 5.0), SIZE)
    for _ in range(20):
        state = state.predicted(DT).updated(sighting(0.0, 5.0))
    refused = state.predicted(DT).updated(sighting(1.0, 2.0))
    assert refused.range == pytest.approx(5.0, rel=0.05)
    for _ in range(20):
        refused = refused.predicted(DT).updated(sighting(1.0, 2.0))
    assert refused.range == pytest.approx(2.0, rel=0.05)
    assert refused.mean[0] == pytest.approx(1.0, abs=0.02)


def test_a_target_that_leaves_and_is_not_seen_for_hours_has_a_range_still():
    state = begin_relative_state(sighting(0.0, 5.0), SIZE)
    for number in range(100):
        state = state.predicted(DT).updated(sighting(0.0, 5.0 * math.exp(0.5 * DT * number)))
    for _ in range(1_000):
        state = state.after_motion(np.eye(3), np.array([0.1, 0.0, 0.0])).predicted(10.0)
    assert math.isfinite(state.range)
    assert np.isfinite(state.position_covariance()).all()
    assert state.range_sigma > state.range


def test_the_position_is_ahead_to_the_left_and_up():
    state = begin_relative_state(sighting(math.pi / 2, 4.0), SIZE)
    assert state.position() == pytest.approx([0.0, 4.0, 0.0], abs=1e-9)
    sigmas = np.sqrt(np.diag(state.position_covariance()))
    assert sigmas[1] == pytest.approx(state.range_sigma)
    assert sigmas[0] == pytest.approx(4.0 * math.radians(0.6))
