"""`cable-tracker simulate`."""

import pytest
from typer.testing import CliRunner

from cable_tracker.cli import app
from cable_tracker.errors import ParameterError
from cable_tracker.sequences.labels.sequence_file import read_labels
from cable_tracker.sequences.labels.target_labels import read_boxes
from cable_tracker.simulation.targets.sequence import simulate_target


def command(*words):
    """Run a command line."""
    return CliRunner().invoke(app, [str(word) for word in ("simulate", *words)])


def test_a_world_is_written_with_its_labels(tmp_path):
    folder = tmp_path / "world"
    options = ("--scenario", "report_clear", "--size", "64x48")
    result = command(folder, *options, "--format", "sequence")
    assert result.exit_code == 0
    assert len(read_labels(folder / "sequence.txt")) == 250


def test_a_world_has_its_own_bottom(tmp_path):
    result = command(tmp_path / "world", "--scenario", "report_clear", "--photographs", tmp_path)
    assert result.exit_code != 0
    assert "has its own bottom" in str(result.exception) + result.output


def test_a_target_is_written_with_its_boxes(tmp_path):
    folder = tmp_path / "dive"
    options = ("--target", "vanishing", "--frames", 12, "--seed", 3)
    result = command(folder, *options, "--format", "sequence")
    assert result.exit_code == 0, result.output
    boxes = list(read_boxes(folder / "boxes.txt").values())
    assert boxes == [frame.box for frame in simulate_target("vanishing", 3, 12)]
    assert None in boxes
    assert boxes[0] is not None


def test_a_target_goes_without_a_cable(tmp_path):
    result = command(tmp_path / "dive", "--target", "buoy", "--scenario", "S1")
    assert isinstance(result.exception, ParameterError)


def test_an_unknown_target_is_refused(tmp_path):
    result = command(tmp_path / "dive", "--target", "whale")
    assert "none of" in str(result.exception)
    assert not (tmp_path / "dive").exists()


@pytest.mark.parametrize(
    "words",
    [
        ("--target", "buoy", "--seed", -1),
        ("--target", "buoy", "--frames", 0),
        ("--target", "buoy", "--frames", 2, "--rate", "1e12"),
        ("--target", "buoy", "--frames", 2, "--rate", "inf"),
        ("--target", "buoy", "--frames", 2, "--rate", "nan"),
        ("--scenario", "tune_clear", "--seed", -1),
        ("--scenario", "tune_clear", "--size", "1x1"),
        ("--survey", 100, "--cable-seed", -1),
        ("--survey", "nan"),
        ("--survey", "inf"),
    ],
)
def test_values_that_cannot_be_are_refused_in_words(tmp_path, words):
    result = command(tmp_path / "dive", *words)
    assert isinstance(result.exception, ParameterError)
    assert not (tmp_path / "dive").exists()
