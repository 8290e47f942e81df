import pytest

from cable_tracker.commands.options.parameters import chosen_parameters, parse_value, single_values
from cable_tracker.errors import ParameterError
from cable_tracker.followed_kinds import CABLE, TARGET
from cable_tracker.target.parameters.presets import TARGET_PRESETS


@pytest.fixture
def choose(tmp_path):
    """Return a function that combines a preset, the text of a file, single words and a seed."""
    file = tmp_path / "mine.yaml"

    def choose_from(kind, text="{}", words=(), *, preset_name=None, seed=None):
        file.write_text(text)
        return chosen_parameters(kind, preset_name, file, single_values(words), seed)[1]

    return choose_from


@pytest.mark.parametrize("equals", ["=", ":=", " = ", ":= "])
def test_a_value_is_given_as_to_the_command_or_as_to_the_node(equals):
    assert parse_value(f"particle_count{equals}300") == ("particle_count", 300)


def test_values_are_read_as_in_a_parameter_file():
    words = ["loss_time=1", "detector:=none", "response_table=", "evidence_limit=1e6"]
    values, parameters = chosen_parameters(CABLE, None, None, single_values(words), None)
    assert values == {
        "loss_time": 1,
        "detector": "none",
        "response_table": "",
        "evidence_limit": 1e6,
    }
    assert values.items() <= parameters.as_mapping().items()


@pytest.mark.parametrize("word", ["particle_count", "=3", ":=3", ""])
def test_a_word_without_name_or_sign_is_refused(word):
    with pytest.raises(ParameterError, match="give a name and a value"):
        parse_value(word)


def test_values_on_the_command_line_win_over_those_of_the_file(choose):
    text = "preset: thesis\nparticle_count: 200\nseed: 3\n"
    chosen = choose(CABLE, text, ["particle_count=300"])
    assert (chosen.particle_count, chosen.seed, chosen.filter) == (300, 3, "bootstrap")


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
def test_the_preset_of_p_wins_over_that_of_the_file_which_wins_over_the_option(
    choose, preset_name, in_file, words, chosen
):
    assert choose(CABLE, in_file, words, preset_name=preset_name).filter == chosen


def test_a_preset_of_targets_in_a_file_wins_over_the_option(choose):
    chosen = choose(TARGET, "preset: thesis", preset_name="default")
    assert chosen == TARGET_PRESETS["thesis"]


@pytest.mark.parametrize("kind", [CABLE, TARGET])
@pytest.mark.parametrize("in_file", ["{}", "preset: thesis"])
def test_an_option_that_names_no_preset_is_refused_whether_it_counts_or_not(choose, kind, in_file):
    with pytest.raises(ParameterError, match="preset: 'dusk' is none of default"):
        choose(kind, in_file, preset_name="dusk")


def test_an_option_that_another_preset_wins_over_is_noted(choose, capsys):
    choose(CABLE, "preset: thesis", preset_name="thesis")
    assert "note" not in capsys.readouterr().err
    choose(CABLE, "preset: default", preset_name="thesis")
    noted = capsys.readouterr().err.replace("\n", " ")
    assert "the preset default is used, which the parameters name, not --preset thesis" in noted


def test_preset_file_and_seed_add_up(choose):
    text = "particle_count: 77\nseed: 3\nimage_transport: raw\n"
    chosen = choose(CABLE, text, preset_name="thesis", seed=9)
    assert (chosen.particle_count, chosen.seed, chosen.rate_damping) == (77, 9, 1.0)


@pytest.mark.parametrize("kind", [CABLE, TARGET])
def test_without_options_the_parameters_are_the_defaults(kind):
    assert chosen_parameters(kind, None, None, {}, None) == ({}, kind.presets["default"])


@pytest.mark.parametrize("kind", [CABLE, TARGET])
def test_the_option_for_the_seed_wins_over_all_other_seeds(choose, kind):
    seeds = [choose(kind, "seed: 3", ["seed=4"], seed=seed).seed for seed in (None, 5)]
    assert seeds == [4, 5]


def test_parameters_of_nodes_are_noted_on_the_command_line_but_not_in_a_file(choose, capsys):
    choose(CABLE, "input_timeout: 2.0", ["initial_state=random"])
    assert not capsys.readouterr().err
    choose(CABLE, "input_timeout: 2.0", ["input_timeout=2.0", "image_transport=raw"])
    assert "note: image_transport, input_timeout: only nodes read this" in capsys.readouterr().err


def test_unknown_names_are_refused(choose):
    with pytest.raises(ParameterError, match="unknown parameter wdith"):
        choose(CABLE, words=["wdith=3"])


@pytest.mark.parametrize(
    ("word", "note"),
    [
        ("initial_width_maximum=300.0", "raise width_maximum too"),
        ("initial_width_minimum=2.0", "lower width_minimum too"),
    ],
)
def test_a_search_for_what_is_not_followed_is_noted(choose, capsys, word, note):
    choose(CABLE, words=[word])
    assert note in capsys.readouterr().err


def test_a_search_within_the_limits_is_not_noted(choose, capsys):
    choose(CABLE, words=["initial_width_maximum=160.0", "initial_width_minimum=8.0"])
    assert "note" not in capsys.readouterr().err


@pytest.mark.parametrize("kind", [CABLE, TARGET])
def test_parameters_of_nodes_in_a_file_are_ignored_and_those_of_the_vehicle_noted(
    choose, kind, capsys
):
    plain = choose(kind)
    assert choose(kind, "image_transport: compressed") == plain
    assert "note" not in capsys.readouterr().err
    assert choose(kind, "camera_pitch: 70.0") == plain
    assert "camera_pitch: only nodes read" in capsys.readouterr().err.replace("\n", " ")


def test_an_initial_target_for_a_node_is_ignored_and_noted(choose, capsys):
    assert choose(TARGET, "initial_target: 1,2,30,40\ntarget_size: 0.4") == choose(TARGET)
    assert "initial_target, target_size: only nodes" in capsys.readouterr().err.replace("\n", " ")


@pytest.mark.parametrize("path", ["/a #b/t.json", "/data/dive: two/t.json", "'/a #b/t.json'"])
def test_a_path_is_taken_as_it_is(path):
    assert parse_value(f"response_table={path}") == ("response_table", path.strip("'"))
