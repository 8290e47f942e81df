"""`cable-tracker convert`."""

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.sequences.bags.open_bag import open_bag
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.encodings import decode_grey, raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.labels.target_labels import own_boxes
from cable_tracker.sequences.source import open_source

from .conftest import GARBAGE

CARRIED = {"/altitude", "/camera_info", "/fix", "/imu", "/odometry", "/tf_static"}


@pytest.fixture
def dive(command):
    """Folder of a simulated bag with instruments."""
    code, _, err = command("simulate", "dive", "--frames", 3, "--size", "64x48", "--seed", 0)
    assert (code, err) == (0, "")
    return Path("dive")


def messages_of(path, topic):
    with closing(open_bag(path)) as storage:
        return [(each.msgtype, each.time, each.data) for each in storage.messages([topic])]


@pytest.mark.parametrize("copy", ["copy", "dive"], ids=["beside it", "in its place"])
def test_instruments_and_the_vehicle_file_are_copied_too(command, dive, copy):
    recorded = {topic: messages_of(dive, topic) for topic in CARRIED}
    vehicle = (dive / "vehicle.yaml").read_bytes()
    assert command("convert", dive, copy, "--force") == (0, f"3 frames: {copy}\n", "")
    assert {topic: messages_of(Path(copy), topic) for topic in CARRIED} == recorded
    assert all(recorded.values())
    assert Path(copy, "vehicle.yaml").read_bytes() == vehicle


@pytest.mark.parametrize("source", ["dive", "dive/dive.mcap"])
def test_a_conversion_onto_itself_that_breaks_off_leaves_the_recording_as_it_was(
    command, dive, source
):
    with closing(open_bag(dive)) as recorded:
        images = list(recorded.messages(["/image"]))
    contents = (images[0].data, b"no message", images[2].data)
    with BagWriter(dive, overwrite=True) as bag:
        for each, content in zip(images, contents, strict=True):
            bag.write_serialised(each.topic, each.msgtype, content, each.time)
    before = {file.name: file.read_bytes() for file in dive.iterdir()}
    code, out, error = command("convert", source, "dive", "--force")
    assert (code, out) == (2, "")
    assert "frame 1 cannot be decoded" in error
    assert "the recording is as it was" in error
    assert {file.name: file.read_bytes() for file in dive.iterdir()} == before
    assert command("convert", source, "beside")[:2] == (2, "1 frames: beside\n")


def test_one_file_of_a_bag_does_not_take_the_place_of_all(command, dive):
    (dive / "dive_1.mcap").write_bytes((dive / "dive.mcap").read_bytes())
    code, _, error = command("convert", dive / "dive.mcap", dive, "--force")
    assert code == 2
    assert "dive: holds dive_1.mcap besides dive.mcap, which would be deleted" in error
    assert (dive / "dive_1.mcap").is_file()


def test_an_edited_vehicle_file_is_kept_with_a_note(command, dive):
    assert command("convert", dive / "dive.mcap", "copy")[0] == 0
    own = Path("copy", "vehicle.yaml")
    own.write_text("camera_x: 0.2\n")
    code, _, error = command("convert", dive, "copy", "--force")
    assert code == 2
    assert "vehicle.yaml: says other things" in error
    (dive / "vehicle.yaml").unlink()
    code, _, notes = command("convert", dive, "copy", "--force")
    assert (code, notes) == (
        0,
        "note: copy: its vehicle.yaml was kept; remove it if the new bag is of another vehicle\n",
    )
    assert own.read_text() == "camera_x: 0.2\n"


def test_an_instrument_can_be_left_out(command, dive):
    assert command("convert", dive, "copy", "--imu-topic", "none")[0] == 0
    assert not messages_of(Path("copy"), "/imu")
    assert messages_of(Path("copy"), "/odometry")


def test_an_ambiguous_altitude_topic_is_not_copied_and_noted(command, dive):
    with closing(open_bag(dive)) as recorded, BagWriter(Path("two")) as bag:
        for each in recorded.messages(["/image", "/altitude"]):
            bag.write_serialised(each.topic, each.msgtype, each.data, each.time)
        below = RosbagsMessages().make("sensor_msgs/msg/Range")
        bag.write("/sonar", "sensor_msgs/msg/Range", below, 2_000_000_000)
    _, _, notes = command("convert", "two", "copy")
    assert notes.startswith("note: two: several topics for altitude, none of them is read")
    assert not messages_of(Path("copy"), "/altitude")
    assert command("convert", "two", "chosen", "--altitude-topic", "sonar")[2] == ""
    assert messages_of(Path("chosen"), "/sonar")


def test_unreadable_messages_are_left_out_with_a_note(command, dive):
    with closing(open_bag(dive)) as recorded, BagWriter(Path("torn")) as bag:
        for each in recorded.messages(["/image", "/altitude"]):
            data = each.data[:10] if each.topic == "/altitude" else each.data
            bag.write_serialised(each.topic, each.msgtype, data, each.time)
    code, _, notes = command("convert", "torn", "copy")
    assert code == 0
    assert notes.startswith("note: torn: /altitude: 3 of its messages cannot be read")


def test_pictures_of_12_bits_are_scaled_to_8_bits_with_a_note(command):
    picture = np.linspace(0, 4095, 48 * 64).reshape(48, 64).astype(np.uint16)
    write_bag(Path("deep"), [Frame(0, 10**9, raw_from_array(picture, "mono16"))])
    code, _, notes = command("convert", "deep", "copy", "--format", "jpeg")
    assert code == 0
    assert notes.startswith("note: deep: its pictures have more than 8 bits and use less than 1/8")
    assert "the levels of all frames were multiplied by 8;" in notes
    with open_source(Path("copy")) as copy:
        assert decode_grey(next(copy.frames()).image).max() == pytest.approx(127, abs=3)
    assert notes.count("\n") == 1
    assert command("convert", "deep", "as_it_is")[2] == ""


def test_a_topic_of_what_is_no_bag_is_refused(command):
    assert command("simulate", "pictures", "--frames", 2, "--format", "sequence")[0] == 0
    code, _, error = command("convert", "pictures", "copy", "--altitude-topic", "/sonar")
    assert code == 2
    assert "error: pictures: is no bag and has no topics; leave out --altitude-topic" in error
    assert not Path("copy").exists()
    assert command("convert", "pictures", "copy", "--altitude-topic", "none")[0] == 0


@pytest.mark.parametrize("kind", ["bag", "sequence"])
def test_true_boxes_of_a_target_are_written(command, kind):
    simulated = ("simulate", "seen", "--target", "buoy", "--frames", 3, "--size", "64x48")
    assert command(*simulated, "--format", kind)[0] == 0
    assert command("convert", "seen", "copy")[0] == 0
    with open_source(Path("seen")) as source, open_source(Path("copy")) as copy:
        boxes = own_boxes(copy)
        before = [own_boxes(source).box(frame) for frame in source.frames()]
        after = [boxes.box(frame) for frame in copy.frames() if boxes.knows(frame)]
    assert len(after) == len(before) == 3
    assert any(before)
    assert np.allclose(after, before, atol=1e-3)


def test_garbage_is_refused_in_one_line_that_names_it(command):
    Path("a.mcap").write_bytes(GARBAGE)
    command("convert", "a.mcap", "out").assert_refused("a.mcap")
    assert [path.name for path in Path().iterdir()] == ["a.mcap"]


def test_the_frames_before_the_damage_are_used_and_the_damage_is_reported(command, unlabelled):
    Path("pictures/frame_000002.png").write_bytes(b"garbage")
    command("convert", unlabelled, "out").assert_broken_off(2, "frame_000002.png")


def test_bad_frames_are_left_out_of_a_converted_recording_on_request(command, unlabelled):
    Path("pictures/frame_000001.png").write_bytes(b"garbage")
    outcome = command("convert", unlabelled, "copy", "--format", "grey", "--skip-bad-frames")
    assert outcome == (0, "2 frames (1 that cannot be decoded left out): copy\n", "")


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("image_format", ["as-is", "grey", "jpeg"])
def test_a_recording_is_converted_with_its_truth(command, bag, storage, image_format):
    options = ("--storage", storage, "--format", image_format)
    outcome = command("convert", bag, "copy", *options)
    assert outcome == (0, "8 frames: copy\n", "")
    with open_source(Path("copy")) as copy, open_source(bag) as original:
        pairs = list(zip(copy.frames(), original.frames(), strict=True))
        assert copy.compressed is (image_format == "jpeg")
    assert [(a.stamp, a.truth) for a, _ in pairs] == [(b.stamp, b.truth) for _, b in pairs]
    command("convert", bag, "copy").assert_refused("copy: exists already")
    assert command("convert", bag, "copy", "--force").code == 0


def test_pictures_become_a_bag_at_the_wanted_rate(command, unlabelled):
    assert command("convert", unlabelled, "copy", "--rate", 10).code == 0
    with AnyReader([Path("copy")]) as reader:
        stamps = [stamp for _, stamp, _ in reader.messages()]
    assert stamps == [1_000_000_000, 1_100_000_000, 1_200_000_000]
    assert "have times of their own" in command("convert", "copy", "again", "--rate", 10).err
