"""A bag of a vehicle that turns before a target, followed with both nodes."""

from chase_bag import write_chase_bag
from rosbags.highlevel import AnyReader
from typer.testing import CliRunner

from cable_tracker.cli import app
from cable_tracker.sequences.bags.typestores import typestore


def test_over_dds_instruments_count_as_they_do_without(tmp_path):
    ((box, _), *_) = write_chase_bag(tmp_path / "dive", 9, tiny=5)
    words = ("target", tmp_path / "dive", "--init", ",".join(str(side) for side in box))
    tables, metres, counts = [], [], []
    for name, flags in (("plain", ()), ("ros", ("--ros",))):
        options = ("--target-size", 0.4, "--no-timing", "--output", tmp_path / name, *flags)
        result = CliRunner().invoke(app, [str(word) for word in (*words, *options)])
        assert result.exit_code == 0, result.output
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
