from functools import partial

import pytest

from cable_tracker.evaluation.evaluation_sequences import simulated_sequences
from cable_tracker.evaluation.experiments.ablation import AblationExperiment
from cable_tracker.evaluation.experiments.catalogue import EXPERIMENTS, FILES
from cable_tracker.evaluation.experiments.thesis_experiments import SpeedExperiment, speed_sequence

pytestmark = pytest.mark.slow


@pytest.fixture
def run(command):
    return partial(command, "dev", "experiment")


def test_an_experiment_writes_table_and_figure(run, monkeypatch, tmp_path):
    def small(seeds, limit):
        return SpeedExperiment(seeds, speed_sequence(limit), particles=(50,), taps=(5, 11))

    monkeypatch.setattr("cable_tracker.commands.dev.experiment.EXPERIMENTS", {"speed": small})
    run = partial(run, "speed", "--seeds", 1, "--frames", 3, "--output", tmp_path / "out")
    result = run()
    assert result.code == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "table.md",
        "table.csv",
        "speed.png",
    }
    assert "particles" in result.out
    assert run("--force").code == 0


@pytest.mark.parametrize("name", ["my_depths.csv", "photo.png", "notes.txt"])
def test_user_files_beside_an_experiment_are_not_lost(run, tmp_path, name):
    (tmp_path / "out").mkdir()
    (tmp_path / "out/table.md").touch()
    (tmp_path / "out" / name).write_text("mine")
    result = run("strips", "--seeds", 1, "--output", tmp_path / "out", "--force")
    result.assert_refused(f"{name}: would be lost")
    assert (tmp_path / "out" / name).read_text() == "mine"


def test_chosen_rows_of_the_ablation_are_run(run, monkeypatch, tmp_path):
    def short(seeds, limit):
        return AblationExperiment(seeds, sequences=simulated_sequences(("S3",), 2))

    monkeypatch.setattr("cable_tracker.commands.dev.experiment.EXPERIMENTS", {"ablation": short})
    result = run(
        "ablation", "--row", "no_network", "--row", "any_width", "--first-seed", 5, "--seeds", 1,
        "--workers", 1, "--output", tmp_path / "out",
    )  # fmt: skip
    assert result.code == 0
    written = [path for path in (tmp_path / "out").iterdir() if path.is_file()]
    files = {path.name: path.read_text() for path in written}
    assert set(files) == {"table.md", "taken_away.csv"}
    assert set(files) <= FILES
    first, second = files["taken_away.csv"].splitlines()[1:]
    assert first.startswith("no_network,")
    assert second.startswith("any_width,")


def test_rows_are_only_for_the_ablation(run, tmp_path):
    result = run("speed", "--row", "default", "--output", tmp_path / "out")
    result.assert_refused("--row chooses what the experiments ablation and")
    assert not any(tmp_path.iterdir())


def test_an_unknown_experiment_is_named_with_what_there_is(run, tmp_path):
    result = run("magic", "--output", tmp_path / "out")
    result.assert_refused(f"experiment: 'magic' is none of {' | '.join(EXPERIMENTS)}")


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_a_path_that_is_taken_is_refused_before_anything_is_run(run, tmp_path, name):
    (tmp_path / "mine").write_text("dear")
    result = run(name, "--output", tmp_path / "mine", "--force")
    result.assert_refused("is no earlier output of this kind")
    assert (tmp_path / "mine").read_text() == "dear"
