from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from cable_tracker.atomic_output import (
    AtomicFile,
    PartialOutput,
    alone_in,
    any_name,
    atomic_file,
    output_file,
    output_folder,
    write_bytes,
)
from cable_tracker.errors import OutputError


def always(_path: Path) -> bool:
    return True


def test_a_committed_folder_lies_in_place(tmp_path):
    folder = PartialOutput(tmp_path / "out", overwrite=False, is_ours=always)
    folder.content.mkdir()
    (folder.content / "a").touch()
    folder.commit()
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "a"]


def test_the_earlier_output_comes_back_when_the_move_fails(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "old").touch()
    folder = PartialOutput(tmp_path / "out", overwrite=True, is_ours=always)
    with pytest.raises(OutputError, match="out"):
        folder.commit()
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "old"]


def interrupt_the_move(folder, monkeypatch):
    """Commit a folder, with a signal when what lay there is aside and it is to take its place."""
    rename = Path.rename

    def stop_at_the_new_one(self, target):
        if self == folder.content:
            raise KeyboardInterrupt
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", stop_at_the_new_one)
    with pytest.raises(KeyboardInterrupt):
        folder.commit()


def test_the_earlier_output_comes_back_when_a_signal_interrupts_the_move(tmp_path, monkeypatch):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "old").touch()
    folder = PartialOutput(tmp_path / "out", overwrite=True, is_ours=always)
    folder.content.mkdir()
    interrupt_the_move(folder, monkeypatch)
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
    with output_folder(path, "mark", overwrite=overwrite, is_own_name=any_name) as folder:
        (folder / "mark").write_text(text)


def test_the_folder_appears_when_all_went_well(tmp_path):
    with output_folder(tmp_path / "out", "mark", overwrite=False, is_own_name=any_name) as folder:
        (folder / "mark").write_text("x")
        assert not (tmp_path / "out").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_nothing_is_left_after_a_failure(tmp_path):
    with (
        pytest.raises(RuntimeError),
        output_folder(tmp_path / "out", "mark", overwrite=False, is_own_name=any_name),
    ):
        raise RuntimeError
    assert not any(tmp_path.iterdir())


def test_an_earlier_folder_is_replaced_only_on_request(tmp_path):
    fill(tmp_path / "out")
    with pytest.raises(OutputError, match="exists already"):
        fill(tmp_path / "out", "2")
    fill(tmp_path / "out", "2", overwrite=True)
    assert (tmp_path / "out" / "mark").read_text() == "2"


def test_a_file_of_the_user_in_an_earlier_folder_is_not_lost(tmp_path):
    def replace():
        with output_folder(
            tmp_path / "out", "mark", overwrite=True, is_own_name="mark".__eq__
        ) as folder:
            (folder / "mark").touch()

    replace()
    (tmp_path / "out" / ".directory").touch()
    replace()
    for name in ("tracker.yaml", "notes.txt"):
        (tmp_path / "out" / name).write_text("mine")
    with pytest.raises(OutputError, match=r"out/notes\.txt and 1 more: would be lost"):
        replace()
    assert (tmp_path / "out" / "tracker.yaml").read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def replacing(path: Path) -> PartialOutput:
    """Begin a folder with a file `new`, in place of one with files `old` and `new`."""
    path.mkdir()
    (path / "old").touch()
    own = {"old", "new"}.__contains__
    folder = PartialOutput(path, overwrite=True, is_ours=always, is_own_name=own)
    folder.content.mkdir()
    (folder.content / "new").touch()
    return folder


def test_a_file_put_into_an_earlier_folder_meanwhile_is_carried_over(tmp_path):
    folder = replacing(tmp_path / "out")
    (tmp_path / "out/notes.txt").write_text("an hour of thoughts")
    (tmp_path / "out/photos").mkdir()
    (tmp_path / "out/photos/1.jpg").touch()
    folder.commit()
    assert sorted(path.name for path in tmp_path.rglob("*")) == [
        "1.jpg", "new", "notes.txt", "out", "photos",
    ]  # fmt: skip
    assert (tmp_path / "out/notes.txt").read_text() == "an hour of thoughts"


def test_a_user_file_is_kept_beside_a_new_one_of_its_name(tmp_path):
    folder = replacing(tmp_path / "out")
    (folder.content / "notes.txt").write_text("ours")
    (tmp_path / "out/notes.txt").write_text("mine")
    folder.commit()
    assert (tmp_path / "out/notes.txt").read_text() == "ours"
    assert (tmp_path / "out/notes.txt.earlier").read_text() == "mine"


def test_a_file_put_there_meanwhile_stays_when_the_move_fails(tmp_path, monkeypatch):
    folder = replacing(tmp_path / "out")
    (tmp_path / "out/notes.txt").write_text("an hour of thoughts")
    interrupt_the_move(folder, monkeypatch)
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["notes.txt", "old", "out"]


def test_a_folder_that_carries_files_over_is_not_refused_for_them(tmp_path):
    (tmp_path / "out").mkdir()
    for name in ("old", "notes.txt"):
        (tmp_path / "out" / name).touch()
    with output_file(
        tmp_path / "out",
        always,
        overwrite=True,
        is_own_name={"old"}.__contains__,
        carries_over=True,
    ) as folder:
        folder.mkdir()
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["notes.txt", "out"]


def test_a_folder_of_another_kind_is_never_replaced(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "photographs").write_text("dear")
    with pytest.raises(OutputError, match="is no earlier output of this kind"):
        fill(tmp_path / "out", overwrite=True)
    assert (tmp_path / "out" / "photographs").read_text() == "dear"


def test_a_file_that_cannot_be_written_leaves_the_one_before_and_nothing_half_written(tmp_path):
    path = tmp_path / "route.gpkg"
    path.write_text("before")
    with pytest.raises(OSError, match="full"), atomic_file(path) as part:
        part.write_text("half")
        part.with_name(f"{part.name}-journal").write_text("half")
        raise OSError("the disk is full")
    assert [each.name for each in tmp_path.iterdir()] == ["route.gpkg"]
    assert path.read_text() == "before"


def test_a_file_takes_its_place_when_it_is_complete(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("before")
    with atomic_file(path, waits=True) as part:
        part.write_text("after")
        assert path.read_text() == "before"
        assert part.name.startswith(".") and part.suffix == ".txt"
    assert path.read_text() == "after"
    assert list(tmp_path.iterdir()) == [path]


def test_an_unwritten_output_leaves_the_earlier_one(tmp_path):
    (tmp_path / "a.txt").write_text("before")
    with atomic_file(tmp_path / "a.txt"):
        pass
    assert (tmp_path / "a.txt").read_text() == "before"


def test_each_process_has_a_part_of_its_own_where_several_write(tmp_path):
    one, many = (AtomicFile(tmp_path / "a.txt", by_many=each).part for each in (False, True))
    assert str(os.getpid()) not in one.name
    assert str(os.getpid()) in many.name


def test_only_what_is_left_of_the_own_part_is_removed(tmp_path):
    for name in ("a[1].txt", ".a1.part.txt", ".a[1].part.txt-journal"):
        (tmp_path / name).touch()
    AtomicFile(tmp_path / "a[1].txt").discard()
    assert {each.name for each in tmp_path.iterdir()} == {"a[1].txt", ".a1.part.txt"}


def test_the_content_is_written_and_nothing_else(tmp_path):
    write_bytes(tmp_path / "a.bin", b"abc")
    assert (tmp_path / "a.bin").read_bytes() == b"abc"
    assert len(list(tmp_path.iterdir())) == 1


def test_an_existing_file_is_replaced(tmp_path):
    (tmp_path / "a.bin").write_bytes(b"a longer content")
    write_bytes(tmp_path / "a.bin", b"abc")
    assert (tmp_path / "a.bin").read_bytes() == b"abc"


def test_a_missing_folder_is_reported(tmp_path):
    with pytest.raises(OutputError, match=r"a\.bin: cannot be written") as caught:
        write_bytes(tmp_path / "missing" / "a.bin", b"abc")
    assert "\n" not in str(caught.value)


def test_a_file_instead_of_a_folder_is_reported(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(OutputError, match=r"a\.bin: cannot be written"):
        write_bytes(tmp_path / "file" / "a.bin", b"abc")


def test_a_folder_in_its_place_is_reported_and_nothing_left(tmp_path):
    (tmp_path / "a.bin").mkdir()
    with pytest.raises(OutputError, match=r"a\.bin: cannot be written"):
        write_bytes(tmp_path / "a.bin", b"abc")
    assert [path.name for path in tmp_path.iterdir()] == ["a.bin"]


def test_a_signal_while_the_folder_is_made_leaves_nothing_behind(tmp_path, monkeypatch):
    make = Path.mkdir

    def make_and_stop(self, *words, **named):
        make(self, *words, **named)
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "mkdir", make_and_stop)
    with (
        pytest.raises(KeyboardInterrupt),
        output_folder(tmp_path / "out", "marker", overwrite=False, is_own_name=any_name),
    ):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_second_run_is_refused_while_the_first_one_writes(tmp_path):
    code = f"from pathlib import Path; {SECOND_RUN}"
    with output_folder(tmp_path / "out", "mark", overwrite=False, is_own_name=any_name) as folder:
        (folder / "mark").write_text("1")
        second = subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        assert second.stdout == (
            "out: another run is writing it; wait until that has ended, or choose another name\n"
        )
        assert (folder / "mark").read_text() == "1"
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "mark"]


SECOND_RUN = """
from cable_tracker.atomic_output import output_file
from cable_tracker.errors import OutputError
try:
    with output_file(Path("out"), Path.is_dir, overwrite=True) as file:
        file.write_text("2")
except OutputError as error:
    print(error)
"""


def test_another_output_of_the_same_process_is_refused_too(tmp_path):
    with (
        output_folder(tmp_path / "out", "mark", overwrite=False, is_own_name=any_name),
        pytest.raises(OutputError, match="another run is writing"),
    ):
        fill(tmp_path / "out")
    fill(tmp_path / "out", overwrite=True)


def test_a_folder_written_piece_by_piece_admits_one_run_at_a_time(tmp_path):
    with (
        alone_in(tmp_path / "new" / "out"),
        pytest.raises(OutputError, match="out: another run is writing it; wait"),
        alone_in(tmp_path / "new" / "out"),
    ):
        pass
    with alone_in(tmp_path / "new" / "out"):
        assert (tmp_path / "new" / "out").is_dir()
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be written"), alone_in(tmp_path / "file" / "out"):
        pass


@pytest.mark.parametrize("kind", ["folder", "file", "link"])
def test_the_remains_of_a_killed_run_are_removed(tmp_path, kind):
    left = tmp_path / ".out.partial"
    if kind == "file":
        left.touch()
    else:
        real = tmp_path / "elsewhere" if kind == "link" else left
        (real / "out").mkdir(parents=True)
        (real / "out" / "half").touch()
        if kind == "link":
            left.symlink_to(real)
    fill(tmp_path / "out")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"mark"}
    assert not left.is_symlink() and not left.exists()
    assert (tmp_path / "elsewhere" / "out" / "half").exists() == (kind == "link")


def test_discarding_again_leaves_what_another_run_writes_by_then(tmp_path):
    first = PartialOutput(tmp_path / "out", overwrite=False, is_ours=always)
    first.discard()
    second = PartialOutput(tmp_path / "out", overwrite=False, is_ours=always)
    second.content.mkdir()
    first.discard()
    second.commit()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("refusal", [errno.EBADF, errno.ENOTSUP, errno.ENOLCK])
def test_outputs_are_written_on_file_systems_without_locks(tmp_path, monkeypatch, refusal):
    def refuse(_descriptor, _operation):
        raise OSError(refusal, os.strerror(refusal))

    monkeypatch.setattr("fcntl.flock", refuse)
    (tmp_path / ".out.partial" / "out").mkdir(parents=True)
    fill(tmp_path / "out")
    assert [path.name for path in tmp_path.rglob("*")] == ["out", "mark"]
