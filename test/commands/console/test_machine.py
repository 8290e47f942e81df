import pytest

from cable_tracker.commands.console.machine import machine, origin_note, typed_command


def test_the_command_can_be_typed_again(monkeypatch):
    monkeypatch.setattr("sys.argv", ["/x/y/cli.py", "evaluate", "--output", "my folder"])
    assert typed_command() == "cable-tracker evaluate --output 'my folder'"


@pytest.mark.parametrize("words", [("--output", "/x/y.json"), ("--output=/x/y.json",)])
def test_a_path_of_one_machine_can_be_left_out_of_the_command(monkeypatch, words):
    monkeypatch.setattr("sys.argv", ["/x/y/cli.py", "dev", "bench", *words, "--dds"])
    assert typed_command(without="--output") == "cable-tracker dev bench --dds"


def test_the_machine_is_one_line():
    text = machine()
    assert "\n" not in text
    assert "Python 3" in text


def test_a_report_names_its_command_and_machine(monkeypatch):
    monkeypatch.setattr("sys.argv", ["/x/y/cli.py", "evaluate"])
    note = origin_note()
    assert note.startswith("`cable-tracker evaluate` on 2")
    assert note.endswith(f", {machine()}.")
