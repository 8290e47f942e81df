from __future__ import annotations

import shutil

import pytest

from cable_tracker.sequences.bag import BagSource
from cable_tracker.sequences.bag_storage import open_storage, storage_files
from cable_tracker.sequences.bag_writer import BagWriter

NAMES = ["my #1", "what?", "p%41", "a?mode=rw#x", "über"]


@pytest.fixture(params=NAMES)
def folder(request, tmp_path):
    made = tmp_path / request.param
    made.mkdir()
    return made


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_bag_is_read_whatever_characters_its_path_has(make_bag, folder, storage):
    bag = shutil.copytree(make_bag(f"{folder.name}/b #2?", storage=storage), folder / "copy")
    assert len(list(BagSource(bag).frames())) == 5
    (file,) = storage_files(bag)
    assert not open_storage(bag).note
    assert len(list(BagSource(file).frames())) == 5


@pytest.mark.parametrize("compression", ["file", "message"])
def test_so_is_a_compressed_one(make_bag, folder, compression):
    bag = make_bag(f"{folder.name}/b #2?", storage="sqlite3", compression=compression)
    assert len(list(BagSource(bag).frames())) == 5


def test_so_is_a_ros1_bag(make_ros1_bag, folder):
    bag = make_ros1_bag(f"{folder.name}/b #2?.bag")
    assert len(list(BagSource(bag).frames())) == 5


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_a_bag_is_written_whatever_characters_its_path_has(folder, maker, storage):
    path = folder / f"b {folder.name}"
    with BagWriter(path, storage) as bag:
        bag.write("/note", "std_msgs/msg/String", maker.text("x"), 1)
    assert [each.name for each in folder.iterdir()] == [path.name]
    assert [each.name for each in folder.parent.iterdir()] == [folder.name]
    assert open_storage(path).topics["/note"].count == 1
    assert len(list(open_storage(path).messages(["/note"]))) == 1
