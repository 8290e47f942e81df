from __future__ import annotations

from pathlib import Path

import pytest

from cable_tracker.errors import OutputError
from cable_tracker.sequences.output_folder import PartialOutput, output_folder


def always(_path: Path) -> bool:
    return True


def test_a_committed_folder_lies_in_place(tmp_path):
    folder = PartialOutput(tmp_path / "out", overwrite=False, is_ours=always)
    folder.content.mkdir()
    (folder.content / "a").touch()
    folder.commit()
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "a"]


def test_what_lay_there_comes_back_when_the_move_fails(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "old").touch()
    folder = PartialOutput(tmp_path / "out", overwrite=True, is_ours=always)
    with pytest.raises(OutputError, match="out"):
        folder.commit()
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "old"]


def test_a_link_is_replaced_not_followed(tmp_path):
    (tmp_path / "target").mkdir()
    (tmp_path / "target" / "kept").touch()
    (tmp_path / "out").symlink_to(tmp_path / "target")
    folder = PartialOutput(tmp_path / "out", overwrite=True, is_ours=always)
    folder.content.mkdir()
    folder.commit()
    assert not (tmp_path / "out").is_symlink()
    assert (tmp_path / "target" / "kept").exists()


def test_discarding_leaves_nothing(tmp_path):
    folder = PartialOutput(tmp_path / "out", overwrite=False, is_ours=always)
    folder.content.mkdir()
    folder.discard()
    assert list(tmp_path.iterdir()) == []


def fill(path, text="1", overwrite=False):
    with output_folder(path, "mark", overwrite=overwrite) as folder:
        (folder / "mark").write_text(text)


def test_the_folder_appears_when_all_went_well(tmp_path):
    with output_folder(tmp_path / "out", "mark", overwrite=False) as folder:
        (folder / "mark").write_text("x")
        assert not (tmp_path / "out").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_nothing_is_left_after_a_failure(tmp_path):
    with pytest.raises(RuntimeError), output_folder(tmp_path / "out", "mark", overwrite=False):
        raise RuntimeError
    assert not any(tmp_path.iterdir())


def test_an_earlier_folder_is_replaced_only_when_told(tmp_path):
    fill(tmp_path / "out")
    with pytest.raises(OutputError, match="exists already"):
        fill(tmp_path / "out", "2")
    fill(tmp_path / "out", "2", overwrite=True)
    assert (tmp_path / "out" / "mark").read_text() == "2"


def test_a_folder_of_another_kind_is_never_replaced(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "photographs").write_text("dear")
    with pytest.raises(OutputError, match="is no earlier output of this kind"):
        fill(tmp_path / "out", overwrite=True)
    assert (tmp_path / "out" / "photographs").read_text() == "dear"
