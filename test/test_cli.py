from __future__ import annotations

import io
import subprocess
import sys
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

import pytest
import typer

from cable_tracker import __version__, cli
from cable_tracker.commands import dev
from cable_tracker.commands.console.lazy_group import PACKAGE
from cable_tracker.errors import OutputError

OLD_TYPER = tuple(map(int, version("typer").split(".")[:2])) < (0, 15)
"""It imports Rich at once, and gives no advice."""


@pytest.mark.parametrize(
    "arguments",
    [
        ("track", "dive", "--preset", "best"),
        ("track",),
        ("track", "dive", "--seed", "x"),
        ("convert", "dive", "out", "--storage", "tape"),
        ("dance",),
    ],
)
def test_wrong_usage_is_explained_with_exit_code_2(command, arguments):
    outcome = command(*arguments)
    assert outcome.code == 2
    assert "Usage" in outcome.err
    assert "Traceback" not in outcome.err


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (["--help"], "  track        Track a recording"),
        (["dev", "--help"], "  soak"),
    ],
)
def test_commands_are_listed_without_importing_what_they_need(words, shown):
    listed, imported = told_and_imported(*words)
    assert shown in listed
    assert imported == "set()\n"


def test_the_version_is_printed_without_importing_the_packages_of_commands():
    assert told_and_imported("--version") == (f"cable-tracker {__version__}\n", "set()\n")


def told_and_imported(*words):
    """What the command prints in a process of its own, and which large packages it has imported."""
    heavy = {"numpy", "cv2", "numba"} | (set() if OLD_TYPER else {"rich"})
    code = (
        f"import sys; from cable_tracker import cli; sys.argv[1:] = {list(words)}\n"
        "try: cli.main()\n"
        f"finally: print({heavy} & set(sys.modules), file=sys.stderr)"
    )
    command = [sys.executable, "-c", code]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    return result.stdout, result.stderr


@pytest.mark.parametrize(("group", "groups"), [((), cli.GROUPS), (("dev",), dev.GROUPS)])
def test_the_help_lists_commands_by_what_one_wants_to_do(command, group, groups):
    shown = command(*group, "--help").out
    titles = [line.removesuffix(":") for line in shown.splitlines() if line.endswith(":")]
    assert titles == ["Options", *groups]
    lines = [line.split(maxsplit=1) for line in shown.splitlines()]
    described = {line[0]: line[1] for line in lines if len(line) == 2}
    names = {name for commands in groups.values() for name in commands}
    assert names <= set(described)
    assert not any(described[name].endswith("...") for name in names)


@pytest.mark.parametrize(
    ("place", "summary"),
    [listed for group in (*cli.GROUPS.values(), *dev.GROUPS.values()) for listed in group.values()],
)
def test_the_overview_has_the_first_line_of_each_command_help(place, summary):
    module, attribute = place.split(":")
    said = getattr(import_module(f"{PACKAGE}.{module}"), attribute)
    words = said.info.help if isinstance(said, typer.Typer) else said.__doc__
    assert words.splitlines()[0] == summary


@pytest.mark.parametrize(
    "name", [*(name for group in cli.GROUPS.values() for name in group), *cli.FORMER_NAMES]
)
def test_every_command_is_found_and_explains_itself(command, name):
    outcome = command(name, "--help")
    assert outcome.code == 0
    assert "Usage" in outcome.out


@pytest.mark.parametrize("name", cli.FORMER_NAMES)
def test_former_names_are_those_of_commands_under_dev(command, name):
    options = [
        command(*words, "--help").out.split("Options")[1] for words in ((name,), ("dev", name))
    ]
    assert options[0] == options[1]
    assert f"  {name} " not in command("--help").out


@pytest.mark.skipif(OLD_TYPER, reason="Typer gives no such advice before 0.15")
def test_a_mistyped_command_is_refused_with_the_right_one(command):
    assert "Did you mean 'track'?" in command("trak").err


def test_a_command_whose_packages_do_not_fit_keeps_none_from_help(command, monkeypatch):
    def fails(name):
        if name.endswith("commands.survey"):
            raise ImportError("pyarrow requires NumPy 2.0 or newer")
        return import_module(name)

    monkeypatch.setattr("cable_tracker.commands.console.lazy_group.import_module", fails)
    shown = command("--help")
    assert shown.code == 0
    assert "survey Map the cable from dives" in " ".join(shown.out.split())
    used = command("survey", "--help")
    assert (used.code, used.out) == (2, "")
    assert "survey cannot be used here: pyarrow requires NumPy 2.0" in used.err


def test_the_command_runs_without_ros_and_ends_without_a_traceback(tmp_path):
    command = [sys.executable, "-m", "cable_tracker.cli", "track", "missing"]
    root = Path(__file__).parents[1]
    result = subprocess.run(
        command,
        cwd=tmp_path,
        env={"PYTHONPATH": str(root), "PATH": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr == "error: missing: there is no such file or folder; check the path\n"


def test_names_that_are_not_utf_8_are_printed_byte_for_byte(monkeypatch):
    out = io.TextIOWrapper(io.BytesIO(), "utf-8")
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr(cli, "app", lambda: print("Tauchg\udce4nge"))
    cli.main()
    out.flush()
    assert out.buffer.getvalue() == b"Tauchg\xe4nge\n"


@pytest.mark.parametrize(
    ("encoding", "printed"),
    [
        ("utf-8", "α in ° of Tauchg".encode()),
        ("latin-1", b"\\u03b1 in \xb0 of Tauchg"),
        ("ascii", b"\\u03b1 in \\xb0 of Tauchg"),
    ],
)
def test_characters_outside_the_encoding_are_printed_as_numbers(monkeypatch, encoding, printed):
    out = io.TextIOWrapper(io.BytesIO(), encoding)
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr(cli, "app", lambda: print("α in ° of Tauchg\udce4nge"))
    cli.main()
    out.flush()
    assert out.buffer.getvalue() == printed + b"\xe4nge\n"


def test_an_error_is_reported_with_the_kept_output(command, monkeypatch):
    def fails():
        error = OutputError("map: cannot be written")
        error.add_note("2 finished tasks are kept in map")
        raise error

    monkeypatch.setattr(cli, "app", fails)
    assert command("survey") == (
        2,
        "",
        "error: map: cannot be written; 2 finished tasks are kept in map\n",
    )
