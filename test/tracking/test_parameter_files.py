from __future__ import annotations

import math
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cable_tracker.cable.parameters.parameters import (
    PARAMETER_TABLE,
    PARAMETERS_BY_NAME,
    TrackerParameters,
)
from cable_tracker.cable.parameters.presets import PRESETS, preset
from cable_tracker.errors import ParameterError
from cable_tracker.tracking.parameter_files import (
    format_parameter_file,
    read_parameter_file,
    write_node_parameters,
)


@pytest.fixture
def written(tmp_path):
    def write(text: str | bytes) -> Path:
        path = tmp_path / "parameters.yaml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


@st.composite
def any_parameters(draw) -> TrackerParameters:
    spec = draw(st.sampled_from([spec for spec in PARAMETER_TABLE if spec.kind is not bool]))
    if spec.choices:
        value = draw(st.sampled_from(spec.choices))
    elif spec.kind is str:
        value = draw(st.text())
    elif spec.kind is int:
        value = draw(st.integers(int(spec.minimum), int(spec.maximum)))
    else:
        value = draw(st.floats(spec.minimum, spec.maximum))
    try:
        return TrackerParameters().replaced({spec.name: value})
    except ParameterError:  # It contradicts another default.
        return TrackerParameters()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(any_parameters())
def test_a_written_parameter_file_is_read_back_exactly(written, parameters):
    path = written(format_parameter_file(parameters, "Any."))
    again = TrackerParameters().replaced(read_parameter_file(path))
    assert again == parameters


@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        "null",
        "~",
        "no",
        "1",
        "1e-5",
        "a b",
        "my # table.json",
        "C:\\x",
        "it's",
        '"',
        "ä",
        "{",
    ],
)
def test_any_text_is_written_so_that_it_is_read_back(written, text):
    parameters = TrackerParameters(response_table=text)
    path = written(format_parameter_file(parameters, "Any."))
    assert read_parameter_file(path)["response_table"] == text


@pytest.mark.parametrize("value", ["1.5e2", "true", "", "a: b", False, 7, 1e-05, -2.5])
def test_the_values_of_a_node_are_read_back_with_their_types(tmp_path, value):
    write_node_parameters(tmp_path / "node.yaml", {"before": 1, "name": value, "after": "word"})
    values = read_parameter_file(tmp_path / "node.yaml")
    assert values == {"before": 1, "name": value, "after": "word"}
    assert type(values["name"]) is type(value)


def test_a_text_that_is_left_out_is_refused(written):
    values = read_parameter_file(written("response_table:\n"))
    with pytest.raises(ParameterError, match="response_table: None is not a word"):
        TrackerParameters().replaced(values)


@pytest.mark.parametrize("name", PRESETS)
def test_written_presets_are_whole_ros_parameter_files(written, name):
    text = format_parameter_file(preset(name), f"Preset {name}.")
    assert text.startswith(f"# Preset {name}.\n")
    assert set(yaml.safe_load(text)["/**"]["ros__parameters"]) == set(PARAMETERS_BY_NAME)


@pytest.mark.parametrize("text", ["1e-5", "1E-5", "1.0e-05", "0.00001", "+1e-5"])
def test_small_numbers_may_be_written_as_in_ros(written, text):
    values = read_parameter_file(written(f"epsilon: {text}\n"))
    assert TrackerParameters().replaced(values).epsilon == 1e-5


@pytest.mark.parametrize(
    "line",
    [
        "particle_count: 1_000",
        "particle_count: 1:30",
        "particle_count: 0b1100100",
        "particle_count: 0x_64",
        "epsilon: 1_0.5e-1",
        "epsilon: 1:30.5",
    ],
)
def test_text_that_is_no_number_for_ros_stays_text(written, line):
    values = read_parameter_file(written(f"{line}\n"))
    name, text = line.split(": ")
    assert values == {name: text}
    with pytest.raises(ParameterError, match=f"{name}: '{text}' is not a"):
        TrackerParameters().replaced(values)


def test_other_whole_numbers_are_those_of_ros(written):
    values = read_parameter_file(written("a: +100\nb: 0x64\nc: 0144\nd: -100\ne: .inf\n"))
    assert values == {"a": 100, "b": 100, "c": 100, "d": -100, "e": math.inf}


@pytest.mark.parametrize(
    ("text", "number"),
    [("08", 8.0), ("+08", 8.0), ("-09", -9.0), ("0190", 190.0), ("'08'", "08"), ("08 m", "08 m")],
)
def test_a_leading_0_of_a_number_that_cannot_be_octal_is_ignored_as_by_ros(written, text, number):
    assert read_parameter_file(written(f"search_time: {text}\n")) == {"search_time": number}


@pytest.mark.parametrize(
    ("text", "number"), [("1.5e2", 150.0), ("1.e2", 100.0), (".5e1", 5.0), ("-2.5E-1", -0.25)]
)
def test_numbers_with_a_fraction_and_an_exponent_are_numbers(written, text, number):
    assert read_parameter_file(written(f"distance_limit: {text}\n")) == {"distance_limit": number}


@pytest.mark.parametrize("text", ["1e1,0,20,0", "1e2,50,150,90", "2e5_table.json", "1e5 m", ".e5"])
def test_words_that_begin_like_a_number_are_words(written, text):
    assert read_parameter_file(written(f"initial_state: {text}\n")) == {"initial_state": text}


def test_a_plain_mapping_is_taken_as_it_is(written):
    assert read_parameter_file(written("seed: 3\nresampling: residual\n")) == {
        "seed": 3,
        "resampling": "residual",
    }


def test_the_sections_for_the_tracker_count_and_later_ones_override(written):
    path = written(
        "/**:\n  ros__parameters: {seed: 1, particle_count: 9}\n"
        "/ship/tracker:\n  ros__parameters: {seed: 2}\n"
        "replay:\n  ros__parameters: {rate: 2.0}\n"
    )
    assert read_parameter_file(path) == {"seed": 2, "particle_count": 9}


@pytest.mark.parametrize(
    "text",
    [
        "ship:\n  tracker:\n    ros__parameters: {seed: 2}\n",
        "/fleet/:\n  ship: {tracker: {ros__parameters: {seed: 2}}}\n",
        "ship:\n  '**': {ros__parameters: {seed: 2}}\n",
        "replay: &same {ros__parameters: {seed: 2}}\ntracker: *same\n",
    ],
)
def test_the_tracker_is_found_in_namespaces(written, text):
    assert read_parameter_file(written(text)) == {"seed": 2}


def test_a_file_for_other_nodes_only_is_refused(written):
    path = written("ship:\n  controller:\n    ros__parameters: {speed: 1.0}\n")
    with pytest.raises(ParameterError, match="nothing for the node tracker, only for /ship/contr"):
        read_parameter_file(path)


def test_namespaces_that_hold_themselves_end(written):
    values = read_parameter_file(written("ship: &ship\n  again: *ship\nseed: 3\n"))
    assert values["seed"] == 3


@pytest.mark.parametrize(
    "content",
    [
        "",
        "[1, 2]",
        "seed",
        "{",
        "a: b: c",
        "\x00\x01",
        b"\xff\xfe\xfa",
        "a: 2020-13-45",
        "a: !!int 0x_",
        "[" * 1000,
        "? [a]\n: b",
        "!!python/object:os.system x",
        "/**:\n  ros__parameters: [1]\n",
        "a: *nothing",
    ],
    ids=lambda content: repr(content)[:20],
)
def test_garbage_is_refused_in_one_line_with_the_file(written, content):
    path = written(content)
    with pytest.raises(ParameterError) as caught:
        read_parameter_file(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "words"),
    [("missing.yaml", "there is no such file; check the path"), (".", "cannot be read")],
)
def test_a_file_that_cannot_be_opened_is_refused(tmp_path, name, words):
    with pytest.raises(ParameterError, match=words):
        read_parameter_file(tmp_path / name)
