from __future__ import annotations

from pathlib import Path

import pytest

from cable_tracker.errors import OutputError
from cable_tracker.sequences.output_folder import PartialOutput


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
