from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.predict.frame_noise import draw_frame_noise

COUNTS = st.integers(0, 40)
TAILS = st.sampled_from([4.0, 1.0, 30.0, math.inf])


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
