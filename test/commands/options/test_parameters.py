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


def filter_of(tmp_path, preset_name, in_file, words) -> str:
    file = tmp_path / "mine.yaml"
    file.write_text(in_file)
    return chosen_parameters(preset_name, given_values(file, words), None).filter


@pytest.mark.parametrize(
    ("preset_name", "in_file", "words", "chosen"),
    [
        (None, "{}", [], "multi_hypothesis"),
        ("thesis", "{}", [], "bootstrap"),
        ("default", "preset: thesis", [], "bootstrap"),
        ("thesis", "preset: default", [], "multi_hypothesis"),
        ("default", "{}", ["preset=thesis"], "bootstrap"),
        ("default", "preset: default", ["preset=thesis"], "bootstrap"),
        ("thesis", "preset: thesis", ["preset=default"], "multi_hypothesis"),
    ],
)
def test_of_presets_that_of_p_wins_over_that_of_the_file_and_that_over_the_option(
    tmp_path, preset_name, in_file, words, chosen
):
    assert filter_of(tmp_path, preset_name, in_file, words) == chosen


def test_a_preset_of_targets_in_a_file_wins_over_the_option():
    assert chosen_target("default", {"preset": "thesis"}, None) == chosen_target("thesis", {}, None)


def test_an_option_that_another_preset_wins_over_is_noted(tmp_path, capsys):
    filter_of(tmp_path, "thesis", "preset: thesis", [])
    assert "note" not in capsys.readouterr().err
    filter_of(tmp_path, "thesis", "preset: default", [])
    noted = capsys.readouterr().err.replace("\n", " ")
    assert "the preset default is used, which the parameters name, not --preset thesis" in noted


@pytest.mark.parametrize("choose", [chosen_parameters, chosen_target])
def test_the_option_for_the_seed_wins_over_all_other_seeds(choose, tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("seed: 3\n")
    values = given_values(file, ["seed=4"])
    assert [choose(None, values, seed).seed for seed in (None, 5)] == [4, 5]


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
