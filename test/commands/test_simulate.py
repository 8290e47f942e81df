"""`cable-tracker simulate`."""

from typer.testing import CliRunner

from cable_tracker.cli import app
from cable_tracker.sequences.sequence_file import read_labels


def command(*words):
    """Run a command line."""
    return CliRunner().invoke(app, [str(word) for word in ("simulate", *words)])


def test_a_world_is_written_with_its_labels(tmp_path):
    folder = tmp_path / "world"
    result = command(folder, "--scenario", "report_clear", "--format", "sequence")
    assert result.exit_code == 0
    assert len(read_labels(folder / "sequence.txt")) == 250


def test_a_world_has_its_own_bottom(tmp_path):
    result = command(tmp_path / "world", "--scenario", "report_clear", "--photographs", tmp_path)
    assert result.exit_code != 0
    assert "has its own bottom" in str(result.exception) + result.output
