"""Whatever happens to a recording, only RecordingError comes out of it."""

from __future__ import annotations

import gc
import sys
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rosbags.rosbag2 import Reader as Reader2

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.storage_files import storage_files
from cable_tracker.sequences.source import open_source

damages = st.lists(st.tuples(st.floats(0, 0.9999), st.integers(0, 255)), min_size=1, max_size=8)


@pytest.fixture(scope="module")
def recordings() -> dict[str, bytes]:
    """Contents of small recordings, filled by the first test that needs them."""
    return {}


def survives(path: Path, content: bytes, changes: list[tuple[float, int]], cut: float) -> None:
    data = bytearray(content)
    for place, value in changes:
        data[int(place * len(data))] = value
    path.write_bytes(data[: int(cut * len(data))])
    count = 0
    try:
        with open_source(path) as source:
            for _ in source.frames():
                count += 1
    except RecordingError as error:
        assert "\n" not in str(error)
        assert path.name in str(error)
    assert count <= 10


def relaxed(test):
    fixtures = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
    return settings(max_examples=25, suppress_health_check=fixtures)(test)


@pytest.mark.parametrize(
    ("storage", "compression"),
    [("mcap", "none"), ("mcap", "storage"), ("sqlite3", "none"), ("sqlite3", "message")],
)
@relaxed
@given(changes=damages, cut=st.floats(0, 1) | st.just(1.0))
def test_a_damaged_ros2_bag(make_bag, recordings, tmp_path, *, storage, compression, changes, cut):
    key = storage + compression
    if key not in recordings:
        folder = make_bag(key, storage=storage, compression=compression, compressed_images=True)
        recordings[key] = storage_files(folder)[0].read_bytes()
    name = "x.mcap" if storage == "mcap" else "x.db3"
    survives(tmp_path / name, recordings[key], changes, cut)


@relaxed
@given(changes=damages, cut=st.floats(0, 1))
def test_a_damaged_mcap_of_a_crashed_recorder(make_bag, recordings, tmp_path, changes, cut):
    if "crashed" not in recordings:
        content = storage_files(make_bag("crashed"))[0].read_bytes()
        recordings["crashed"] = content[: content.rindex(b"rosbag2") - 200]
    survives(tmp_path / "x.mcap", recordings["crashed"], changes, cut)


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
@relaxed
@given(changes=damages, cut=st.floats(0, 1) | st.just(1.0))
def test_a_damaged_ros1_bag(make_ros1_bag, recordings, tmp_path, *, compression, changes, cut):
    if compression not in recordings:
        recordings[compression] = make_ros1_bag(
            f"{compression}.bag", compression=compression
        ).read_bytes()
    survives(tmp_path / "x.bag", recordings[compression], changes, cut)


@relaxed
@given(changes=damages, cut=st.just(1.0))
def test_damaged_metadata_is_read_or_refused_in_one_line(make_bag, recordings, changes, cut):
    if "metadata" not in recordings:
        folder = make_bag("whole")
        recordings["metadata"] = (folder / "metadata.yaml").read_bytes()
        recordings["folder"] = str(folder).encode()
    folder = Path(recordings["folder"].decode())
    data = bytearray(recordings["metadata"])
    for place, value in changes:
        data[int(place * len(data))] = value
    (folder / "metadata.yaml").write_bytes(data)
    try:
        with open_source(folder) as source:
            for _ in source.frames():
                pass
    except RecordingError as error:
        assert "\n" not in str(error)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc/self/fd")
@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("share", [1.0, 0.7])
def test_no_file_stays_open(make_bag, storage, share):
    path = make_bag(frames=20, storage=storage, size=(64, 48))
    file = storage_files(path)[0]
    content = file.read_bytes()
    file.write_bytes(content[: int(share * len(content))])
    # What earlier tests have left behind is not closed in between, then.
    gc.collect()
    before = len(list(Path("/proc/self/fd").iterdir()))
    with open_source(path) as source:
        frames = source.frames()
        next(frames)
        next(source.frames())
    assert len(list(Path("/proc/self/fd").iterdir())) == before
    with pytest.raises(StopIteration):
        next(frames)


def test_topics_are_counted(make_bag):
    storage = open_bag(make_bag(frames=6))
    assert {name: topic.count for name, topic in storage.topics.items()} == {
        "/camera/image": 6,
        "/sim/ground_truth": 3,
        "/chatter": 6,
    }


def test_only_the_wanted_topics_are_read(make_bag):
    messages = list(open_bag(make_bag()).messages(["/chatter"]))
    assert len(messages) == 5
    assert {message.topic for message in messages} == {"/chatter"}


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_bag_is_opened_once_for_all_readings(make_bag, storage, monkeypatch):
    opened = []
    open_reader = Reader2.open
    monkeypatch.setattr(
        Reader2, "open", lambda reader: (opened.append(reader), open_reader(reader))
    )
    bag = open_bag(make_bag(frames=6, storage=storage))
    together = list(zip(bag.messages(["/camera/image"]), bag.messages(["/chatter"]), strict=False))
    assert len(together) == len(list(bag.messages(["/chatter"]))) == 6
    assert len(opened) == 1


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_closing_ends_a_reading_and_the_next_opens_the_bag_again(make_bag, storage):
    bag = open_bag(make_bag(storage=storage))
    begun = bag.messages(["/chatter"])
    first = next(begun)
    bag.close()
    assert next(begun, None) is None
    again = next(bag.messages(["/chatter"]))
    assert (again.time, again.data) == (first.time, first.data)


@pytest.fixture
def crashed(make_bag, tmp_path):
    """Folder of a recorder that crashed: it has compressed its finished files, and no metadata."""
    folder = tmp_path / "crashed"
    folder.mkdir()
    for number, compression in ((0, "file"), (10, "file"), (9, "none")):
        (file,) = make_bag(f"part{number}", compression=compression).glob("*.mcap*")
        file.rename(folder / f"dive_{number}{''.join(file.suffixes)}")
    return folder


def images(path):
    with closing(open_bag(path)) as storage:
        return storage.note, len(list(storage.messages(["/camera/image"])))


def test_the_compressed_files_of_a_crashed_recorder_are_read(crashed):
    note = "metadata.yaml is missing; 3 files were read one after the other"
    assert images(crashed) == (note, 15)
    (crashed / "dive_9.mcap").unlink()
    with open_source(crashed) as source:
        assert len(list(source.frames())) == 10
    with open_source(crashed / "dive_0.mcap.zstd") as source:
        assert (source.note, len(list(source.frames()))) == ("", 5)


def test_copies_of_compressed_files_go_with_their_reader(crashed, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    storage = open_bag(crashed)
    assert list((tmp_path / "temporary").rglob("*.mcap"))
    del storage
    gc.collect()
    assert not list((tmp_path / "temporary").iterdir())


def test_a_file_that_was_still_being_compressed_is_read_itself(crashed):
    packed = (crashed / "dive_0.mcap.zstd").read_bytes()
    (crashed / "dive_9.mcap.zstd").write_bytes(packed[: len(packed) // 2])
    assert images(crashed)[1] == 15


def test_damage_of_a_compressed_file_is_reported_after_the_readable_frames(crashed):
    packed = bytearray((crashed / "dive_10.mcap.zstd").read_bytes())
    (crashed / "dive_10.mcap.zstd").write_bytes(packed[: len(packed) // 2])
    note, count = images(crashed)
    assert note.startswith("it has no end")
    assert 10 <= count < 15
    packed[4:40] = b"\xff" * 36
    (crashed / "dive_10.mcap.zstd").write_bytes(packed)
    with pytest.raises(RecordingError, match=r"dive_10\.mcap\.zstd cannot be unpacked to its end"):
        images(crashed)


def test_the_unpacked_size_of_compressed_files_is_limited(crashed, monkeypatch):
    monkeypatch.setattr("cable_tracker.sequences.bags.bag_limits.FREE_SHARE", 0.0)
    with pytest.raises(RecordingError, match="half of the free space"):
        open_bag(crashed)
