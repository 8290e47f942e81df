from __future__ import annotations

import pytest

from cable_tracker.cable.parameters.parameters import (
    PARAMETER_TABLE,
    PARAMETERS_BY_NAME,
    TrackerParameters,
)
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import ParameterError

NUMBERS = [spec for spec in PARAMETER_TABLE if spec.kind in (int, float)]


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


def test_ranges_read_well():
    assert PARAMETERS_BY_NAME["rate_damping"].range_text() == "0 .. 1"
    assert PARAMETERS_BY_NAME["limit_handling"].range_text() == "clip | reflect"


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


def test_the_mapping_holds_all_in_the_order_of_the_table():
    mapping = TrackerParameters().as_mapping()
    assert list(mapping) == [spec.name for spec in PARAMETER_TABLE] == list(PARAMETERS_BY_NAME)
    assert TrackerParameters(**mapping) == TrackerParameters()


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
def test_presets_have_no_remarks(name):
    assert preset(name).remarks() == ()
