from __future__ import annotations

import pytest

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import PRESETS, preset
from cable_tracker.errors import ParameterError

TABLE_5_1 = {
    "distance_variance": 0.5,
    "angle_variance": 0.01,
    "width_variance": 4.0,
    "skew_variance": 0.1,
    "distance_rate_variance": 8.0,
    "angle_rate_variance": 0.005,
}
TABLE_5_2 = {
    "initial_distance_range": 150.0,
    "initial_angle_range": 45.0,
    "initial_width_minimum": 5.0,
    "initial_width_maximum": 100.0,
    "initial_skew_maximum": 10.0,
    "initial_distance_rate_range": 1.0,
    "initial_angle_rate_range": 0.1,
}
TEXT = {
    "particle_count": 500,
    "resampling": "multinomial",
    "resampling_threshold": 0.5,
    "rate_damping": 1.0,
    "sample_spacing": 20.0,
    "filter_sigma": 1.6,
}


@pytest.mark.parametrize("numbers", [TABLE_5_1, TABLE_5_2, TEXT])
def test_the_preset_thesis_has_the_numbers_of_the_thesis(numbers):
    thesis = preset("thesis").as_mapping()
    assert {name: thesis[name] for name in numbers} == numbers


def test_the_preset_default_is_the_default():
    assert preset("default") == TrackerParameters()
    assert list(PRESETS) == ["default", "pipeline", "thesis"]


def test_an_unknown_preset_is_refused_with_those_there_are():
    with pytest.raises(ParameterError, match=r"'best' is none of default \| pipeline \| thesis"):
        preset("best")
