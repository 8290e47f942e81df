from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.parameters.parameters import (
    PARAMETER_TABLE,
    PARAMETERS_BY_NAME,
    TrackerParameters,
)
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import ParameterError
from cable_tracker.tracking.parameter_table import ParameterSpec

NUMBERS = [spec for spec in PARAMETER_TABLE if spec.kind in (int, float)]
WORDS = [spec for spec in PARAMETER_TABLE if spec.choices]


def test_every_default_is_acceptable_and_everything_is_explained():
    for spec in PARAMETER_TABLE:
        assert spec.coerce(spec.default) == spec.default
        assert type(spec.default) is spec.kind, spec.name
        assert spec.meaning.endswith("."), spec.name
        assert spec.range_text(), spec.name


def test_both_ends_of_a_range_are_accepted_and_nothing_beyond():
    for spec in NUMBERS:
        for end in (spec.minimum, spec.maximum):
            assert spec.coerce(end) == end
            assert type(spec.coerce(end)) is spec.kind, spec.name
        for beyond in (spec.minimum - 1, spec.maximum * 1.01 + 1):
            with pytest.raises(ParameterError, match=spec.name):
                spec.coerce(spec.kind(beyond))


@pytest.mark.parametrize(
    "value",
    [float("nan"), float("inf"), -float("inf"), True, False, "3", "", None, [1], 10**400, 1j],
    ids=repr,
)
def test_what_is_no_finite_number_is_refused_in_one_line(value):
    for spec in NUMBERS:
        with pytest.raises(ParameterError, match=spec.name) as caught:
            spec.coerce(value)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("value", ["", "other", 1, True, None])
def test_what_is_no_choice_is_refused(value):
    for spec in WORDS:
        with pytest.raises(ParameterError, match=spec.name):
            spec.coerce(value)


@pytest.mark.parametrize("value", [1, True, None, 0.5])
def test_what_is_no_text_is_refused_where_any_text_will_do(value):
    spec = PARAMETERS_BY_NAME["response_table"]
    assert spec.coerce("any.json") == "any.json"
    with pytest.raises(ParameterError, match="is not a word"):
        spec.coerce(value)


def test_switches_are_true_or_false_and_nothing_else():
    switch = ParameterSpec("lights", bool, False, "", "Light.", None, None, ())
    assert switch.coerce(True) is True
    assert switch.range_text() == "true | false"
    for value in (1, 0.0, "true", None):
        with pytest.raises(ParameterError, match="not true or false"):
            switch.coerce(value)


def test_ranges_read_well():
    assert PARAMETERS_BY_NAME["rate_damping"].range_text() == "0 .. 1"
    assert PARAMETERS_BY_NAME["limit_handling"].range_text() == "clip | reflect"


def test_a_whole_number_is_accepted_where_a_float_is_meant():
    value = TrackerParameters(distance_variance=3).distance_variance
    assert (value, type(value)) == (3.0, float)


def test_a_float_without_fraction_is_accepted_where_a_whole_number_is_meant():
    value = TrackerParameters(particle_count=200.0).particle_count
    assert (value, type(value)) == (200, int)
    with pytest.raises(ParameterError, match=r"200\.5 is not a whole number"):
        TrackerParameters(particle_count=200.5)


@pytest.mark.parametrize(
    ("low", "high"),
    [
        ("width_minimum", "width_maximum"),
        ("initial_width_minimum", "initial_width_maximum"),
        ("evidence_to_lose", "evidence_to_track"),
    ],
)
def test_pairs_that_contradict_each_other_are_refused(low, high):
    with pytest.raises(ParameterError, match=f"{low} = 31 must not exceed {high} = 30"):
        TrackerParameters(**{low: 31, high: 30})
    assert getattr(TrackerParameters(**{low: 30, high: 30}), low) == 30


def test_a_contradiction_with_a_value_that_stays_is_refused():
    with pytest.raises(ParameterError, match="set both together"):
        TrackerParameters().replaced({"width_minimum": 250.0})
    both = TrackerParameters().replaced({"width_minimum": 250.0, "width_maximum": 300.0})
    assert both.width_maximum == 300.0


@pytest.mark.parametrize("name", ["presence_to_track", "presence_to_lose"])
def test_a_presence_that_is_never_reached_is_no_threshold(name):
    with pytest.raises(ParameterError, match=rf"{name}: 0\.994 is outside 0 \.\. 0\.993"):
        TrackerParameters().replaced({"presence_to_track": 0.993, name: 0.994})


@pytest.mark.parametrize(
    ("shares", "left"),
    [((0.04, 0.0, 0.9), "0"), ((0.05, 0.0, 0.9), "0"), ((0.2, 0.9, 0.5), "0.024")],
)
def test_shares_that_leave_too_few_particles_to_follow_the_cable_are_refused(shares, left):
    detector, search, refinement = shares
    values = {"detector_share": detector, "search_share": search, "refinement_share": refinement}
    with pytest.raises(ParameterError, match=rf"leave {left} of the particles .* at least 0\.04"):
        TrackerParameters(**values)


def test_scan_lines_that_no_border_crosses_three_of_are_refused():
    with pytest.raises(ParameterError, match=r"sample_spacing: 61\.0 is outside 1 \.\. 60 px"):
        TrackerParameters(sample_spacing=61.0)


def test_replacing_is_all_or_nothing():
    before = TrackerParameters()
    with pytest.raises(ParameterError, match="epsilon"):
        before.replaced({"particle_count": 7, "epsilon": -1.0})
    assert before == TrackerParameters()
    after = before.replaced({"particle_count": 7, "epsilon": 1e-6})
    assert (after.particle_count, after.epsilon) == (7, 1e-6)
    assert dataclasses.replace(after, particle_count=500, epsilon=1e-3) == before


def test_unknown_names_are_refused_and_named():
    with pytest.raises(ParameterError, match=r"unknown parameter colour, size;"):
        TrackerParameters().replaced({"size": 1, "colour": 2, "seed": 3})


def test_the_mapping_holds_all_in_the_order_of_the_table():
    mapping = TrackerParameters().as_mapping()
    assert list(mapping) == [spec.name for spec in PARAMETER_TABLE] == list(PARAMETERS_BY_NAME)
    assert TrackerParameters(**mapping) == TrackerParameters()


@given(st.dictionaries(st.sampled_from(list(PARAMETERS_BY_NAME)), st.none() | st.integers()))
def test_any_set_of_values_is_taken_or_refused_with_a_reason(values):
    try:
        replaced = TrackerParameters().replaced(values)
    except ParameterError as error:
        assert "\n" not in str(error)
    else:
        assert {name: getattr(replaced, name) for name in values} == values


@pytest.mark.parametrize(
    "values", [{"observation": "responses"}, {"observation": "responses", "seed": 3}]
)
def test_a_filter_and_an_observation_that_do_not_go_together_are_refused_with_both_ways_out(values):
    needs = "multi_hypothesis needs observation = likelihood_ratio, .*responses needs .*bootstrap"
    with pytest.raises(ParameterError, match=f"{needs}; set both together$"):
        TrackerParameters().replaced(values)
    bootstrap = TrackerParameters(filter="bootstrap", observation="responses")
    with pytest.raises(ParameterError, match=needs):
        bootstrap.replaced({"filter": "multi_hypothesis"})


@pytest.mark.parametrize(
    ("values", "remark"),
    [
        ({"initial_width_maximum": 300.0}, "raise width_maximum too"),
        ({"width_maximum": 100.0}, "raise width_maximum too"),
        ({"initial_width_minimum": 2.0}, "lower width_minimum too"),
        ({"width_minimum": 20.0}, "lower width_minimum too"),
    ],
)
def test_a_search_outside_the_limits_is_accepted_with_a_remark(values, remark):
    (said,) = TrackerParameters().replaced(values).remarks()
    assert remark in said


@pytest.mark.parametrize("name", ["default", "thesis"])
def test_of_the_presets_nothing_is_remarked(name):
    assert preset(name).remarks() == ()
