from __future__ import annotations

import errno
import sqlite3

import pytest
from rosbags.rosbag2 import Reader, Writer

from cable_tracker.errors import OutputError, RecordingError
from cable_tracker.sequences.bags.bag_writer import BagWriter, StorageFormat
from cable_tracker.sequences.bags.rosbags_messages import typestore
from cable_tracker.sequences.source import open_source

IMAGE = "sensor_msgs/msg/Image"
TEXT = "std_msgs/msg/String"
STORAGES = pytest.mark.parametrize("storage", list(StorageFormat))


@pytest.fixture
def image(maker, picture, first_stamp):
    return maker.image(first_stamp, picture(0))


def names(folder) -> set[str]:
    return {path.name for path in folder.iterdir()}


@STORAGES
def test_a_written_bag_can_be_read(tmp_path, maker, picture, first_stamp, storage):
    path = tmp_path / "out"
    with BagWriter(path, storage) as bag:
        for index in range(3):
            stamp = first_stamp + index
            bag.write("/image", IMAGE, maker.image(stamp, picture(index)), stamp)
            bag.write_serialised("/note", TEXT, maker.serialise(maker.text("x")), stamp)
    assert names(tmp_path) == {"out"}
    assert [frame.stamp for frame in open_source(path).frames()] == [
        first_stamp + k for k in range(3)
    ]
    with Reader(path) as reader:
        assert {c.topic: (c.msgtype, c.msgcount) for c in reader.connections} == {
            "/image": (IMAGE, 3),
            "/note": (TEXT, 3),
        }
        assert all(c.msgdef.data for c in reader.connections)


@STORAGES
def test_the_storage_file_is_named_like_the_bag(tmp_path, storage):
    with BagWriter(tmp_path / "out", storage):
        pass
    suffix = {"mcap": "mcap", "sqlite3": "db3"}[storage]
    assert names(tmp_path / "out") == {"metadata.yaml", f"out.{suffix}"}
    assert f"out.{suffix}" in (tmp_path / "out" / "metadata.yaml").read_text()


def test_a_file_of_the_user_in_an_earlier_bag_is_not_lost(tmp_path):
    def write():
        with BagWriter(tmp_path / "out", overwrite=True):
            pass

    write()
    (tmp_path / "out" / "vehicle.yaml").touch()
    write()
    (tmp_path / "out" / "labels.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"out/labels\.txt: .* move it elsewhere"):
        write()
    assert (tmp_path / "out" / "labels.txt").read_text() == "mine"


def test_an_edited_vehicle_file_is_not_overwritten(tmp_path):
    def write(vehicle=None):
        with BagWriter(tmp_path / "out", overwrite=True, vehicle=vehicle):
            pass

    write()
    own = tmp_path / "out" / "vehicle.yaml"
    own.write_text("camera_x: 0.2\n")
    write()
    write(b"camera_x: 0.2\n")
    with pytest.raises(OutputError, match=r"out/vehicle\.yaml: .*move it elsewhere"):
        write(b"camera_x: 0.3\n")
    assert own.read_text() == "camera_x: 0.2\n"
    assert names(tmp_path) == {"out"}


@STORAGES
def test_an_empty_bag_is_valid(tmp_path, storage):
    with BagWriter(tmp_path / "out", storage):
        pass
    with Reader(tmp_path / "out") as reader:
        assert reader.message_count == 0
    with pytest.raises(RecordingError, match="no topics"):
        open_source(tmp_path / "out")


@STORAGES
def test_a_bag_appears_only_when_it_is_complete(tmp_path, image, storage):
    with BagWriter(tmp_path / "out", storage) as bag:
        bag.write("/image", IMAGE, image, 1)
        assert names(tmp_path) == {".out.partial"}


@STORAGES
@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt])
def test_nothing_is_left_after_an_exception(tmp_path, image, storage, failure):
    with pytest.raises(failure), BagWriter(tmp_path / "out", storage) as bag:
        bag.write("/image", IMAGE, image, 1)
        raise failure
    assert names(tmp_path) == set()


def test_an_existing_bag_is_overwritten_on_demand(make_bag, image):
    path = make_bag()
    with BagWriter(path, overwrite=True) as bag:
        bag.write("/image", IMAGE, image, 1)
        assert open_source(path).frame_count == 5
    assert open_source(path).frame_count == 1
    assert names(path.parent) == {"bag"}


def test_the_old_bag_stays_when_the_new_one_fails(make_bag):
    path = make_bag()
    with pytest.raises(ValueError, match="x"), BagWriter(path, overwrite=True):
        raise ValueError("x")
    assert open_source(path).frame_count == 5


def test_leftovers_of_a_killed_process_do_not_disturb(tmp_path):
    (tmp_path / ".out.partial" / "out").mkdir(parents=True)
    with BagWriter(tmp_path / "out"):
        pass
    assert names(tmp_path) == {"out"}


def test_missing_folders_are_made(tmp_path):
    with BagWriter(tmp_path / "a" / "b"):
        pass
    assert (tmp_path / "a" / "b" / "metadata.yaml").exists()


@pytest.mark.parametrize("stamp", [-1, 2**63 - 1])
def test_an_impossible_time_is_refused(tmp_path, image, stamp):
    with pytest.raises(OutputError, match="no time"), BagWriter(tmp_path / "out") as bag:
        bag.write("/image", IMAGE, image, stamp)
    assert names(tmp_path) == set()


@pytest.mark.parametrize("method", ["open", "write", "close"])
@pytest.mark.parametrize(
    "failure", [OSError(errno.ENOSPC, "No space left on device"), sqlite3.OperationalError("full")]
)
def test_a_full_disk_is_an_output_error(tmp_path, image, monkeypatch, method, failure):
    def fail(*_arguments):
        raise failure

    monkeypatch.setattr(Writer, method, fail)
    with (
        pytest.raises(OutputError, match=r"out: cannot be written .*check the folder"),
        BagWriter(tmp_path / "out") as bag,
    ):
        bag.write("/image", IMAGE, image, 1)
    assert names(tmp_path) == set()


def test_the_typestore_is_made_once():
    assert typestore() is typestore()
