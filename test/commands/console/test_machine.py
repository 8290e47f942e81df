from cable_tracker.commands.console.machine import machine, typed_command


def test_the_command_can_be_typed_again(monkeypatch):
    monkeypatch.setattr("sys.argv", ["/x/y/cli.py", "evaluate", "--output", "my folder"])
    assert typed_command() == "cable-tracker evaluate --output 'my folder'"


def test_the_machine_is_one_line():
    text = machine()
    assert "\n" not in text
    assert "Python 3" in text
