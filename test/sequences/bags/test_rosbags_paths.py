from __future__ import annotations

import os
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing, suppress

import pytest

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.bag_writer import BagWriter, StorageFormat
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.storage_files import storage_files
from cable_tracker.sequences.source import open_source

NAMES = ["my #1", "what?", "p%41", "a?mode=rw#x", "über"]


@pytest.fixture(params=NAMES)
def folder(request, tmp_path):
    made = tmp_path / request.param
    made.mkdir()
    return made


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_bag_is_read_whatever_characters_its_path_has(make_bag, folder, storage):
    bag = shutil.copytree(make_bag(f"{folder.name}/b #2?", storage=storage), folder / "copy")
    assert len(list(open_source(bag).frames())) == 5
    (file,) = storage_files(bag)
    assert not open_bag(bag).note
    assert len(list(open_source(file).frames())) == 5


@pytest.mark.parametrize("compression", ["file", "message"])
def test_a_compressed_bag_is_read_whatever_characters_its_path_has(make_bag, folder, compression):
    bag = make_bag(f"{folder.name}/b #2?", storage="sqlite3", compression=compression)
    assert len(list(open_source(bag).frames())) == 5


def test_a_ros1_bag_is_read_whatever_characters_its_path_has(make_ros1_bag, folder):
    bag = make_ros1_bag(f"{folder.name}/b #2?.bag")
    assert len(list(open_source(bag).frames())) == 5


@pytest.mark.parametrize("storage", list(StorageFormat))
def test_a_bag_is_written_whatever_characters_its_path_has(folder, maker, storage):
    path = folder / f"b {folder.name}"
    with BagWriter(path, storage) as bag:
        bag.write("/note", "std_msgs/msg/String", maker.text("x"), 1)
    assert [each.name for each in folder.iterdir()] == [path.name]
    assert [each.name for each in folder.parent.iterdir()] == [folder.name]
    assert open_bag(path).topics["/note"].count == 1
    assert len(list(open_bag(path).messages(["/note"]))) == 1


@pytest.mark.parametrize(
    ("storage", "name"), [("sqlite3", "DIVE.DB3"), ("sqlite3", "dive.Db3"), ("mcap", "DIVE.MCAP")]
)
def test_the_suffix_of_a_bag_may_be_in_upper_case(make_bag, tmp_path, storage, name):
    (file,) = storage_files(make_bag(storage=storage))
    folder = tmp_path / "copied"
    folder.mkdir()
    shutil.copy(file, folder / name)
    for path in (folder / name, folder):
        with open_source(path) as source:
            assert len(list(source.frames())) == 5
            assert source.has_truth


def test_the_suffix_of_a_ros1_bag_may_be_in_upper_case(make_ros1_bag, tmp_path):
    bag = make_ros1_bag("OLD.BAG")
    assert len(list(open_source(bag).frames())) == 5
    with pytest.raises(RecordingError, match=r"name the file: OLD\.BAG"):
        open_source(tmp_path)


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_damaged_bag_with_a_suffix_in_upper_case_is_read_up_to_the_damage(
    make_bag, tmp_path, storage
):
    (file,) = storage_files(make_bag(storage=storage, frames=200))
    path = shutil.copy(file, tmp_path / f"CUT{file.suffix.upper()}")
    os.truncate(path, file.stat().st_size * 3 // 4)
    frames = 0
    with suppress(RecordingError):
        for _ in open_source(path).frames():
            frames += 1
    assert 50 < frames < 200


def test_a_database_with_a_suffix_in_upper_case_is_checked_too(tmp_path):
    path = tmp_path / "VIEWS.DB3"
    with closing(sqlite3.connect(path)) as database:
        database.execute("CREATE VIEW messages AS SELECT 1")
    with pytest.raises(RecordingError, match="views"):
        open_source(path)


WITHOUT_UTF8 = {
    **os.environ,
    "LC_ALL": "C",
    "PYTHONUTF8": "0",
    "PYTHONCOERCECLOCALE": "0",
}


def run_without_utf8(program, *paths):
    """Run a program in a locale without UTF-8; return what it prints."""
    words = [sys.executable, "-c", program, *map(os.fsencode, paths)]
    done = subprocess.run(words, env=WITHOUT_UTF8, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode(errors="replace")
    return done.stdout.decode().split()


READ = """
import sys
from pathlib import Path
from cable_tracker.sequences.source import open_source
for path in sys.argv[1:]:
    print(len(list(open_source(Path(path)).frames())))
"""

WRITE = """
import sys
from pathlib import Path
from cable_tracker.sequences.bags.bag_writer import BagWriter, StorageFormat
from cable_tracker.sequences.bags.rosbags_messages import typestore
for path in map(Path, sys.argv[1:]):
    with BagWriter(path, StorageFormat(path.parent.name)) as bag:
        text = typestore().types["std_msgs/msg/String"]("x")
        bag.write("/note", "std_msgs/msg/String", text, 1)
"""


def test_a_bag_is_read_where_the_locale_is_not_utf_8(make_bag):
    bags = [make_bag(f"über_{storage}", storage=storage) for storage in ("sqlite3", "mcap")]
    assert run_without_utf8(READ, *bags) == ["5", "5"]


def test_a_bag_that_was_written_where_the_locale_is_not_utf_8_is_read_elsewhere(tmp_path):
    paths = []
    for storage in ("sqlite3", "mcap"):
        (tmp_path / storage).mkdir()
        paths += [tmp_path / storage / name for name in ("über", os.fsdecode(b"\xfcber"))]
    run_without_utf8(WRITE, *paths)
    for path in paths:
        assert len(list(open_bag(path).messages(["/note"]))) == 1
