import math

import pytest

from cable_tracker.errors import ParameterError
from cable_tracker.simulation.settings import (
    check_frames,
    check_range,
    check_seed,
    check_size,
)


@pytest.mark.parametrize("value", [0.3, 20.0, 1])
def test_numbers_within_their_limits_are_taken(value):
    check_range("altitude", value, (0.3, 20.0), "m")


@pytest.mark.parametrize("value", [0.29, 20.1, math.nan, math.inf])
def test_what_is_beyond_its_limits_is_refused_with_them(value):
    with pytest.raises(ParameterError, match=rf"altitude is {value}: give 0\.3 to 20 m"):
        check_range("altitude", value, (0.3, 20.0), "m")


def test_seeds_are_not_negative():
    check_seed(0)
    with pytest.raises(ParameterError, match="seed is -1"):
        check_seed(-1)


@pytest.mark.parametrize("size", [(31, 240), (320, 4097)])
def test_images_have_their_limits(size):
    with pytest.raises(ParameterError, match="32 to 4096 px"):
        check_size(size)


@pytest.mark.parametrize("rate", [0.0, 1e-4, 1e7, math.nan, math.inf])
def test_frame_rates_have_their_limits(rate):
    with pytest.raises(ParameterError, match=r"give 0\.001 to 1000000 frames per second"):
        check_frames(1, rate)


def test_a_dive_has_a_frame():
    check_frames(1, 25.0)
    with pytest.raises(ParameterError, match="at least 1 frame"):
        check_frames(0, 25.0)
