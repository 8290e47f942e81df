from __future__ import annotations

import pytest
from typer.testing import CliRunner

from cable_tracker.cli import app
from cable_tracker.errors import CableTrackerError, OutputError, ParameterError

pytest.importorskip("rclpy")


def run(*arguments: str) -> None:
    result = CliRunner().invoke(app, arguments)
    if isinstance(result.exception, CableTrackerError):
        raise result.exception
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--length", "0", "length is 0"),
        ("--buried", "200", "buried is 200"),
        ("--size", "large", "is not of the form 320x240"),
        ("--seed", "-1", "seed is -1"),
    ],
)
def test_what_cannot_be_run_is_refused(tmp_path, option, value, words):
    with pytest.raises(ParameterError, match=words):
        run("loop", option, value, "--output", str(tmp_path / "loop"))


def test_a_folder_that_is_taken_is_refused(tmp_path):
    (tmp_path / "loop").mkdir()
    with pytest.raises(OutputError, match="exists already"):
        run("loop", "--output", str(tmp_path / "loop"))


def test_live_needs_no_folder_and_takes_none(tmp_path):
    with pytest.raises(ParameterError, match="--live publishes and writes nothing"):
        run("simulate", str(tmp_path / "dive"), "--live")
    with pytest.raises(ParameterError, match="name a folder"):
        run("simulate")
