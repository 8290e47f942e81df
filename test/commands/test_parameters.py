"""`cable-tracker parameters`."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console

from cable_tracker.cable.parameters.parameters import PARAMETERS_BY_NAME
from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.commands import parameters
from cable_tracker.commands.options.parameters import chosen_parameters
from cable_tracker.followed_kinds import CABLE
from cable_tracker.tracking.parameter_files import read_parameter_file


@pytest.mark.parametrize("width", [60, 80, 200])
def test_parameters_are_printed_with_whole_names_in_any_width(command, monkeypatch, width):
    monkeypatch.setattr(parameters, "console", Console(width=width))
    outcome = command("parameters")
    assert outcome.code == 0
    assert all(name in outcome.out for name in set(PARAMETERS_BY_NAME))
    assert "Number of particles N; time per frame" in " ".join(outcome.out.split())


def test_parameters_are_printed_as_a_file_for_track(command):
    outcome = command("parameters", "--preset", "thesis", "--format", "yaml")
    Path("thesis.yaml").write_text(outcome.out, encoding="utf-8")
    assert set(read_parameter_file(Path("thesis.yaml"))) == set(PARAMETERS_BY_NAME)
    _, chosen = chosen_parameters(CABLE, None, Path("thesis.yaml"), {}, None)
    assert chosen == PRESETS["thesis"]


@pytest.mark.parametrize("encoding", [pytest.param("latin-1", marks=pytest.mark.slow), "ascii"])
def test_units_are_printed_in_every_locale(encoding):
    words = [sys.executable, "-m", "cable_tracker.cli", "parameters"]
    environment = {**os.environ, "PYTHONIOENCODING": encoding}
    printed = subprocess.run(words, capture_output=True, env=environment, check=True)
    assert b"px" in printed.stdout and not printed.stderr
