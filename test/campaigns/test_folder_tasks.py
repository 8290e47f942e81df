from __future__ import annotations

import os

import pytest
from campaign_tasks import Failing, Square

from cable_tracker.campaigns.folder_tasks import (
    MARKER,
    fingerprint_of_files,
    forget,
    is_done,
    run_in_folder,
)
from cable_tracker.errors import OutputError, RecordingError


def run(task, root):
    run_in_folder(task, root, "1.0", lambda count: None)


def test_the_folder_of_a_task_appears_with_its_marker(tmp_path):
    run(Square(3), tmp_path / "root")
    folder = tmp_path / "root" / "number_3"
    assert {each.name for each in folder.iterdir()} == {"square.txt", MARKER}
    assert [each.name for each in folder.parent.iterdir()] == ["number_3"]


def test_a_folder_is_that_of_a_task_of_the_same_input_and_version(tmp_path):
    run(Square(3), tmp_path)
    folder = tmp_path / "number_3"
    assert is_done(Square(3), folder, "1.0")
    assert not is_done(Square(3), folder, "1.1")
    assert not is_done(Square(3, parameter="another"), folder, "1.0")
    assert not is_done(Square(4), tmp_path / "number_4", "1.0")


def test_names_that_are_not_utf_8_count_too(tmp_path):
    one, other = (tmp_path / os.fsdecode(name) for name in (b"dive\xe4", b"dive\xf6"))
    assert fingerprint_of_files(one) != fingerprint_of_files(other)


def test_a_task_that_fails_leaves_the_results_of_an_earlier_one(tmp_path):
    run(Square(3), tmp_path)
    with pytest.raises(RecordingError, match="no frames"):
        run(Failing(3, parameter="mistyped"), tmp_path)
    assert [each.name for each in tmp_path.iterdir()] == ["number_3"]
    assert is_done(Square(3), tmp_path / "number_3", "1.0")
    assert not is_done(Failing(3, parameter="mistyped"), tmp_path / "number_3", "1.0")


def test_a_file_that_is_written_to_has_another_fingerprint(tmp_path):
    (tmp_path / "a").write_text("1")
    before = fingerprint_of_files(tmp_path)
    assert fingerprint_of_files(tmp_path) == before
    (tmp_path / "a").write_text("12")
    assert fingerprint_of_files(tmp_path) != before


@pytest.mark.parametrize("task", [Square(3), Failing(3)])
def test_a_folder_that_no_task_has_left_is_neither_replaced_nor_removed(tmp_path, task):
    recording = tmp_path / "number_3" / "dive.mcap"
    recording.parent.mkdir()
    recording.write_text("raw")
    with pytest.raises(OutputError, match="not overwritten"):
        run(task, tmp_path)
    assert recording.read_text() == "raw"


def test_results_that_count_no_more_are_done_again(tmp_path):
    run(Square(3), tmp_path)
    forget(tmp_path / "number_3")
    assert not is_done(Square(3), tmp_path / "number_3", "1.0")
    run(Square(3), tmp_path)
    assert is_done(Square(3), tmp_path / "number_3", "1.0")


def test_a_task_that_fails_leaves_nothing_where_there_was_nothing(tmp_path):
    with pytest.raises(RecordingError, match="no frames"):
        run(Failing(3), tmp_path)
    assert not list(tmp_path.iterdir())
