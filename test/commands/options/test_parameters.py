from pathlib import Path

import pytest

from cable_tracker.commands.options.parameters import (
    chosen_parameters,
    chosen_target,
    given_values,
    parse_value,
)
from cable_tracker.errors import ParameterError


@pytest.mark.parametrize("equals", ["=", ":=", " = ", ":= "])
def test_a_value_is_given_as_to_the_command_or_as_to_the_node(equals):
    assert parse_value(f"particle_count{equals}300") == ("particle_count", 300)


def test_values_are_read_as_in_a_parameter_file():
    words = ["loss_time=1", "detector:=none", "response_table=", "evidence_limit=1e6"]
    assert given_values(None, words) == {
        "loss_time": 1,
        "detector": "none",
        "response_table": "",
        "evidence_limit": 1e6,
    }


@pytest.mark.parametrize("word", ["particle_count", "=3", ":=3", ""])
def test_a_word_without_name_or_sign_is_refused(word):
    with pytest.raises(ParameterError, match="give a name and a value"):
        parse_value(word)


def test_values_on_the_command_line_win_over_those_of_the_file(tmp_path):
    file = Path(tmp_path / "mine.yaml")
    file.write_text("preset: thesis\nparticle_count: 200\nseed: 3\n")
    chosen = chosen_parameters(None, given_values(file, ["particle_count=300"]), None)
    assert (chosen.particle_count, chosen.seed, chosen.filter) == (300, 3, "bootstrap")


def test_what_only_nodes_read_is_noted_on_the_command_line_alone(capsys, tmp_path):
    file = tmp_path / "node.yaml"
    file.write_text("input_timeout: 2.0\n")
    given_values(file, ["initial_state=random"])
    assert not capsys.readouterr().err
    given_values(file, ["input_timeout=2.0", "image_transport=raw"])
    assert "note: image_transport, input_timeout: only nodes read this" in capsys.readouterr().err


def test_unknown_names_are_refused():
    with pytest.raises(ParameterError, match="unknown parameter wdith"):
        chosen_parameters(None, given_values(None, ["wdith=3"]), None)


@pytest.mark.parametrize(
    ("values", "note"),
    [
        ({"initial_width_maximum": 300.0}, "raise width_maximum too"),
        ({"initial_width_minimum": 2.0}, "lower width_minimum too"),
    ],
)
def test_a_search_for_what_is_not_followed_is_noted(capsys, values, note):
    chosen_parameters(None, values, None)
    assert note in capsys.readouterr().err


def test_a_search_within_the_limits_is_not_noted(capsys):
    chosen_parameters(None, {"initial_width_maximum": 160.0, "initial_width_minimum": 8.0}, None)
    assert "note" not in capsys.readouterr().err


@pytest.mark.parametrize("choose", [chosen_parameters, chosen_target])
def test_what_only_a_node_reads_is_passed_over_and_what_is_of_the_vehicle_noted(choose, capsys):
    plain = choose(None, {}, None)
    assert choose(None, {"image_transport": "compressed"}, None) == plain
    assert "note" not in capsys.readouterr().err
    assert choose(None, {"camera_pitch": 70.0}, None) == plain
    assert "camera_pitch: only nodes read" in capsys.readouterr().err.replace("\n", " ")


def test_where_a_target_is_said_to_begin_for_a_node_is_noted(capsys):
    values = {"initial_target": "1,2,30,40", "target_size": 0.4}
    assert chosen_target(None, values, None) == chosen_target(None, {}, None)
    assert "initial_target, target_size: only nodes" in capsys.readouterr().err.replace("\n", " ")


@pytest.mark.parametrize("path", ["/a #b/t.json", "/data/dive: two/t.json", "'/a #b/t.json'"])
def test_a_path_is_taken_as_it_is(path):
    assert parse_value(f"response_table={path}") == ("response_table", path.strip("'"))
