"""Commands that replace a folder of theirs, in which the user has put files."""

import pytest

pytest.importorskip("rclpy")

SMALL = ("--size", "64x48", "--frames", 2)
COMMANDS = {
    "simulate a cable": (("simulate", "out", *SMALL, "--format", "sequence"), "sequence.txt"),
    "simulate a target": (
        ("simulate", "out", *SMALL, "--target", "vanishing", "--format", "sequence"), "boxes.txt",
    ),
    "evaluate": (
        ("evaluate", "--scenario", "report_clear", "--method", "thesis", "--output", "out"),
        "report.html",
    ),
    "evaluate targets": (
        ("evaluate", "--targets", "--frames", 2, "--method", "CamShift", "--output", "out"),
        "table.md",
    ),
    "loop": (("loop", "--output", "out"), "loop.csv"),
    "loops": (("loop", "--seeds", 2, "--output", "out"), "runs.csv"),
    "chase": (("chase", "--output", "out"), "chase.csv"),
}  # fmt: skip
"""What is run, and what tells a folder that it has written."""


@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_with_user_files_is_not_replaced(command, tmp_path, name):
    words, marker = COMMANDS[name]
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / marker).touch()
    (tmp_path / "out" / "notes.txt").write_text("mine")
    code, _, error = command(*words, "--force")
    assert code == 2
    assert error.splitlines()[-1] == (
        "error: out/notes.txt: would be lost with the earlier output and is not overwritten;"
        " move it elsewhere, or choose another name"
    )
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("name", ["simulate a cable", "simulate a target"])
def test_a_folder_of_pictures_is_replaced(command, tmp_path, name):
    words, marker = COMMANDS[name]
    assert command(*words)[0] == 0
    (tmp_path / "out" / marker).write_text("")
    code, _, error = command(*words, "--force")
    assert (code, error) == (0, "")
    assert (tmp_path / "out" / marker).read_text() != ""
