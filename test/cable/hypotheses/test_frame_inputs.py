from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.frame_inputs import (
    FIRST_POWER,
    LOST_DETECTOR_SHARE,
    annealing_power,
    beside_a_known_cable,
    draw_frame_noise,
    frame_config,
    refined_counts,
    sample_counts,
)
from cable_tracker.cable.hypotheses.predicted_density import LEAST_PROBABILITY
from cable_tracker.cable.parameters.parameters import TrackerParameters

NO_ROUNDS = np.zeros(0, np.int64)
MASSES = st.floats(LEAST_PROBABILITY, 0.5)

COUNTS = st.integers(0, 40)
TAILS = st.sampled_from([4.0, 1.0, 30.0, math.inf])


def test_beside_a_known_cable_other_strips_count_less_and_the_map_where_it_shows_more():
    parameters = TrackerParameters()
    search = frame_config(parameters, 4.0, (320, 240))
    known = beside_a_known_cable(search, parameters)
    assert known.is_known and not search.is_known
    assert known.map_weights.overlap < search.map_weights.overlap
    assert sum(known.map_weights) == search.map_weights.overlap
    assert known.evidence_limit == parameters.evidence_limit_known
    assert search.evidence_limit == parameters.evidence_limit
    changed = {"evidence_limit": None, "is_known": None, "map_weights": None}
    for before, after in zip(search._replace(**changed), known._replace(**changed), strict=True):
        assert before is after


@given(st.integers(1, 6))
def test_the_power_of_the_likelihood_rises_round_by_round_to_one(rounds):
    powers = [annealing_power(number, rounds) for number in range(rounds)]
    assert powers[0] == pytest.approx(FIRST_POWER)
    assert powers == sorted(powers)
    if rounds > 1:
        assert powers[-1] == 1.0


@given(st.integers(1, 4))
def test_the_rounds_share_all_and_the_last_has_most(rounds):
    parameters = TrackerParameters(refinement_rounds=rounds)
    refined = parameters.refinement_share * parameters.particle_count
    counts = refined_counts(parameters)
    assert len(counts) == rounds
    assert refined - rounds <= counts.sum() <= refined
    assert counts.max() == counts[-1]


def test_without_a_round_none_is_drawn_in_any():
    assert len(refined_counts(TrackerParameters(refinement_rounds=0))) == 0


def counts_of(count, survived, born, detections, refined=NO_ROUNDS):
    parameters = TrackerParameters(particle_count=count)
    return sample_counts(parameters, density_of(survived, born), detections, refined)


def density_of(survived, born):
    """Return what is read of a predicted density, half of its births about a remembered cable."""
    births = SimpleNamespace(share=0.5)
    return SimpleNamespace(mass_survived=survived, mass_born=born, births=births)


@given(
    st.integers(10, 5000), MASSES, MASSES, st.integers(0, 8),
    st.floats(0.0, 0.6),
)  # fmt: skip
def test_every_particle_is_drawn_from_something(count, survived, born, detections, refined):
    rounds = np.array([int(0.4 * refined * count), int(0.6 * refined * count)], np.int64)
    counts = counts_of(count, survived, born, detections, rounds)
    parts = (counts.survivors, counts.births, counts.switches, counts.detections)
    assert sum(parts) + rounds.sum() == count
    assert min(parts) >= 0
    assert counts.births_about_memory <= counts.births


@pytest.mark.parametrize("existing", [0.01, 0.99], ids=["searching", "tracked"])
@pytest.mark.parametrize(
    "shares",
    [(0.1, 0.0, 0.8), (0.04, 0.0, 0.86), (0.9, 0.0, 0.0), (0.0, 0.0, 0.9), (0.1, 0.5, 0.7)],
)
def test_whatever_shares_are_accepted_leave_particles_to_follow_a_cable_or_search_one(
    shares, existing
):
    names = ("detector_share", "search_share", "refinement_share")
    parameters = TrackerParameters(particle_count=500, **dict(zip(names, shares, strict=True)))
    counts = sample_counts(
        parameters, density_of(existing, LEAST_PROBABILITY), 3, refined_counts(parameters)
    )
    assert counts.survivors + counts.births >= 20
    if existing > 0.5:
        assert counts.survivors >= 20


def test_detections_get_more_particles_while_there_is_more_likely_no_cable():
    lost, held = counts_of(500, 0.1, 0.1, 3), counts_of(500, 0.9, 0.05, 3)
    assert lost.detections >= int(500 * LOST_DETECTOR_SHARE) > held.detections
    assert counts_of(500, 0.1, 0.1, 0).detections == 0


@given(COUNTS, COUNTS, TAILS)
def test_every_particle_has_a_row_and_every_birth_another(count, births, tail):
    noise = draw_frame_noise(np.random.default_rng(0), count, births, tail)
    assert noise.normal.shape == noise.uniform.shape == (count, 8)
    assert noise.tail_factors.shape == (count, 2)
    assert noise.about_memory.shape == (births, 4)
    assert ((noise.uniform >= 0.0) & (noise.uniform < 1.0)).all()
    assert (noise.tail_factors > 0.0).all()


@given(st.integers(0, 2**32 - 1), TAILS)
def test_the_same_seed_gives_the_same_numbers_and_another_seed_others(seed, tail):
    one, same, other = (
        draw_frame_noise(np.random.default_rng(number), 20, 5, tail)
        for number in (seed, seed, seed + 1)
    )
    for first, second in zip(one, same, strict=True):
        np.testing.assert_array_equal(first, second)
    assert not np.array_equal(one.normal, other.normal)
    assert not np.array_equal(one.uniform, other.uniform)
    assert not np.array_equal(one.about_memory, other.about_memory)


def test_a_gaussian_is_not_stretched(rng):
    noise = draw_frame_noise(rng, 30, 0, math.inf)
    np.testing.assert_array_equal(noise.tail_factors, 1.0)


def test_pose_and_rates_have_heavy_tails_and_jump_independently(rng):
    noise = draw_frame_noise(rng, 40_000, 0, 4.0)
    pose = np.abs(noise.normal[:, :4] * noise.tail_factors[:, :1])
    rates = np.abs(noise.normal[:, 4:] * noise.tail_factors[:, 1:])
    for part in (pose, rates):
        # Quantiles of |t| with 4 degrees of freedom.
        assert np.median(part) == pytest.approx(0.741, rel=0.03)
        assert (part > 4.604).mean() == pytest.approx(0.01, rel=0.3)
    far = pose[:, 0] > np.quantile(pose[:, 0], 0.99)
    assert np.median(rates[far]) == pytest.approx(np.median(rates), rel=0.2)
    assert np.median(pose[far, 1]) > 2 * np.median(pose)


def test_the_noise_about_the_memory_is_that_of_its_density(rng):
    noise = np.abs(draw_frame_noise(rng, 0, 20_000, math.inf).about_memory)
    assert np.median(noise) == pytest.approx(0.741, rel=0.03)
    assert (noise > 4.604).mean() == pytest.approx(0.01, rel=0.3)
