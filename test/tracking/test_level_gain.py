from __future__ import annotations

from math import frexp

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.tracking.level_gain import (
    LARGEST_GAIN,
    NARROW,
    WIDE,
    amplified,
    byte_gain,
    level_gain,
)

LEVELS = np.linspace(0.0, 1.0, 120 * 160, dtype=np.float32).reshape(120, 160)
SPREADS = st.floats(1e-3, 255.0)
GAINS = st.sampled_from([2.0**power for power in range(9)])


def spread_over(levels: float) -> np.ndarray:
    """Return a picture whose percentiles 2 and 98 are about that far apart."""
    return LEVELS * np.float32(levels / 0.96)


@pytest.mark.parametrize("spread", [10.0, 60.0, 240.0])
def test_a_picture_that_uses_its_levels_stays_as_it_is(spread):
    picture = spread_over(spread)
    assert amplified(picture, level_gain(1.0, picture)) is picture


@given(SPREADS, GAINS)
def test_the_gain_is_a_power_of_two_that_spreads_levels_like_bytes(spread, before):
    gain = level_gain(before, spread_over(spread))
    assert 1.0 <= gain <= LARGEST_GAIN
    assert frexp(gain)[0] == 0.5
    within = NARROW * 0.99 <= gain * spread <= WIDE * 1.01
    assert within or (gain == 1.0 and spread > NARROW) or (gain == LARGEST_GAIN and spread < NARROW)


@given(SPREADS, GAINS, st.floats(0.6, 1.6))
def test_a_little_more_or_less_light_leaves_it(spread, before, light):
    gain = level_gain(before, spread_over(spread))
    if gain in (1.0, LARGEST_GAIN) or gain == before:
        return
    assert level_gain(gain, spread_over(spread * light)) == gain


@pytest.mark.parametrize("before", [1.0, 64.0])
def test_a_flat_picture_keeps_the_gain(before):
    assert level_gain(before, np.full((120, 160), 0.3, np.float32)) == before


def test_a_mark_burned_into_a_dim_picture_does_not_hide_its_scene():
    picture = spread_over(0.5)
    picture[:8, :16] = 255.0
    assert level_gain(1.0, picture) > 16.0


@given(st.floats(0.0, 250.0), SPREADS)
def test_the_gain_before_rounding_to_bytes_cuts_off_no_levels(darkest, spread):
    picture = np.minimum(np.float32(darkest) + spread_over(spread), np.float32(255.0))
    gain = byte_gain(picture)
    assert gain in {1.0, *(2.0**power for power in range(9))}
    assert gain == 1.0 or np.percentile(gain * picture, 98.0) < 128.0


def test_a_dim_picture_in_colour_is_amplified_before_it_is_rounded():
    picture = np.stack([spread_over(0.5)] * 3, axis=2)
    assert byte_gain(picture) == 64.0
    assert byte_gain(picture.astype(np.uint8)) == 1.0
