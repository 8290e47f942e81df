import dataclasses
from functools import partial

import pytest
from typer.testing import CliRunner

from cable_tracker.cli import app
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.experiments import EXPERIMENTS, SPEED_SEQUENCE, SpeedExperiment


def run(*arguments):
    return CliRunner().invoke(app, ["experiment", *map(str, arguments)])


def test_an_experiment_writes_table_and_figure(monkeypatch, tmp_path):
    short = partial(
        SpeedExperiment,
        sequence=dataclasses.replace(SPEED_SEQUENCE, limit=3),
        particles=(50,),
        taps=(5, 11),
    )
    monkeypatch.setattr("cable_tracker.commands.experiment.EXPERIMENTS", {"speed": short})
    result = run("speed", "--seeds", 1, "--output", tmp_path / "out")
    assert result.exit_code == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "table.md",
        "table.csv",
        "speed.png",
    }
    assert "particles" in result.stdout


def test_an_unknown_experiment_is_named_with_what_there_is(tmp_path):
    result = run("magic", "--output", tmp_path / "out")
    assert isinstance(result.exception, ParameterError)
    assert str(result.exception) == f"experiment: 'magic' is none of {' | '.join(EXPERIMENTS)}"


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_a_path_that_is_taken_is_refused_before_anything_is_run(tmp_path, name):
    (tmp_path / "mine").write_text("dear")
    result = run(name, "--output", tmp_path / "mine", "--force")
    assert "is no earlier output of this kind" in str(result.exception)
    assert (tmp_path / "mine").read_text() == "dear"
