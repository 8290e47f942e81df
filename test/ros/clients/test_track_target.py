import cv2
import pytest
from chase_bag import write_chase_bag
from rosbags.highlevel import AnyReader

from cable_tracker.sequences.bags.rosbags_messages import typestore
from cable_tracker.simulation.targets.sequence import simulate_target


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "dive"
    path.mkdir()
    for index, frame in enumerate(simulate_target("near_surface", 2, 7)):
        cv2.imwrite(str(path / f"{index:03}.png"), frame.image)
    return path


@pytest.mark.parametrize("start", ["box", pytest.param("detect", marks=pytest.mark.slow)])
def test_over_dds_the_table_is_the_same(command, folder, tmp_path, start):
    (folder / "006.png").rename(folder / "206.png")
    box = next(simulate_target("near_surface", 2, 1)).box
    init = ",".join(str(side) for side in box) if start == "box" else start
    tables = []
    for name, flags in (("plain", []), ("ros", ["--ros"])):
        output = tmp_path / name
        arguments = ["target", folder, "--init", init, "--no-timing", "--output", output, *flags]
        result = command(*arguments)
        assert result.code == 0, result.err
        tables.append((output / "estimates.csv").read_bytes())
        assert {path.name for path in output.iterdir()} == {
            "estimates.csv", "overlay.webm", "overlay.png", "bag",
        }  # fmt: skip
    assert tables[0] == tables[1]
    assert tables[0].count(b"TRACKING") >= 4
    assert b"no frame for 8.040 s" in tables[0]


def test_over_dds_instruments_count_as_they_do_without(command, tmp_path):
    ((box, _), *_) = write_chase_bag(tmp_path / "dive", 9, tiny=5)
    words = ("target", tmp_path / "dive", "--init", ",".join(str(side) for side in box))
    tables, metres, counts = [], [], []
    for name, flags in (("plain", ()), ("ros", ("--ros",))):
        options = ("--target-size", 0.4, "--no-timing", "--output", tmp_path / name, *flags)
        result = command(*words, *options)
        assert result.code == 0, result.err
        tables.append((tmp_path / name / "estimates.csv").read_bytes())
        metres.append((tmp_path / name / "metres.csv").read_bytes())
        with AnyReader([tmp_path / name / "bag"], default_typestore=typestore()) as reader:
            counts.append({each.topic: each.msgcount for each in reader.connections})
    assert tables[0] == tables[1]
    assert tables[0].count(b"TRACKING") == 8
    assert tables[0].count(b"REFUSED") == 1
    for topic in ("/bearing", "/relative_pose"):
        assert [each[topic] for each in counts] == [8, 8]
    assert metres[0] == metres[1]
    header, *rows = metres[0].decode().splitlines()
    assert header.startswith("frame,stamp,bearing_x")
    assert len(rows) == 9
