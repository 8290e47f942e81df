"""`cable-tracker track`."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from estimate_reader import read_estimates

from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_image

from .conftest import GARBAGE, small_dive

TABLE_ALONE = ("--no-video", "--no-bag", "--no-pictures")
"""What a test looks at that looks at estimates."""


def test_a_bag_is_tracked_into_a_folder(command, bag):
    outcome = command("track", bag, "--init", "truth", "--seed", 1)
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith("8 frames: 8 TRACKING\n")
    assert "8 of 8 labelled frames claimed; 0.0% of those off" in outcome.out
    assert "alpha" in outcome.out
    rows = read_estimates(Path("dive_tracked/estimates.csv"))
    assert [row.status for row in rows] == ["TRACKING"] * 8
    for line in outcome.out.splitlines()[-5:]:
        assert Path(line.strip()).exists()


def test_with_a_vehicle_file_the_reason_for_missing_metres_is_noted(command, bag):
    Path("vehicle.yaml").write_text("fixed_altitude: 2.0\n")
    outcome = command("track", bag, "--init", "truth", "--vehicle", "vehicle.yaml")
    assert "\nno metres: no camera calibration (8 claims)\n" in outcome.out
    rows = read_estimates(Path("dive_tracked/estimates.csv"))
    assert all(row.no_metres.startswith("no camera calibration: ") for row in rows)


def test_the_same_seed_gives_the_same_table_and_another_one_does_not(command, bag):
    tables = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        options = ("--init", "truth", "--seed", seed, "--output", name, "--no-timing")
        assert command("track", bag, *options, *TABLE_ALONE).code == 0
        tables.append(Path(name, "estimates.csv").read_bytes())
    assert tables[0] == tables[1] != tables[2]


def test_a_start_may_have_a_negative_first_number(command, bag):
    assert command("track", bag, "--init", "-5,0.1,9,0", *TABLE_ALONE).code == 0


def test_a_detection_needs_the_evidence_of_a_find_and_the_truth_does_not(command, bag):
    demanding = ("-p", "evidence_to_find=100", "--force", *TABLE_ALONE)

    def statuses(init):
        assert command("track", bag, "--init", init, "--output", "out", *demanding).code == 0
        return {row.status for row in read_estimates(Path("out") / "estimates.csv")}

    assert statuses("truth") == {"TRACKING"}
    assert statuses("hough") == {"INITIALISING"}


def test_a_missing_recording_is_refused(command):
    command("track", "nothing.mcap").assert_refused("nothing.mcap: there is no such file or folder")


@pytest.mark.parametrize("name", ["a.mcap", "a.mp4", "a.txt", "a"])
def test_garbage_is_refused_in_one_line_that_names_it(command, name):
    Path(name).write_bytes(GARBAGE)
    command("track", name).assert_refused(name)
    assert [path.name for path in Path().iterdir()] == [name]


@pytest.mark.parametrize("init", ["", "1,2,3"])
def test_a_bad_start_is_refused(command, bag, init):
    command("track", bag, "--init", init).assert_refused("initial state")
    assert not Path("dive_tracked").exists()


def test_truth_needs_labels(command, unlabelled):
    command("track", unlabelled, "--init", "truth").assert_refused("no ground truth to start from")
    assert not Path("pictures_tracked").exists()


def test_a_bad_parameter_file_is_refused(command, bag):
    Path("p.yaml").write_text("particle_count: 0\n")
    command("track", bag, "--params", "p.yaml").assert_refused(
        "particle_count: 0 is outside 1 .. 1"
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--params", "missing.yaml"), "missing.yaml: there is no such file"),
        (("--seed", "-1"), "seed: -1 is outside"),
        (("--rate", "0"), "rate must be a positive number"),
        (("--topic", "/other"), "/other"),
        (("--truth", "labels.txt"), "labels.txt"),
    ],
)
def test_other_bad_options_are_refused(command, bag, options, words):
    command("track", bag, *options).assert_refused(words)


@pytest.mark.parametrize("output", [".", "/"])
def test_an_output_without_a_name_is_refused(command, bag, output):
    command("track", bag, "--output", output, "--force").assert_refused("no name for a new output")


def test_a_bag_of_a_crashed_recorder_is_tracked_as_far_as_it_goes(command, bag):
    stored = Path("dive/dive.mcap")
    Path("cut.mcap").write_bytes(stored.read_bytes()[: stored.stat().st_size * 5 // 8])
    outcome = command("track", "cut.mcap", "--init", "truth", *TABLE_ALONE)
    rows = read_estimates(Path("cut_tracked/estimates.csv"))
    assert 1 <= len(rows) < 8
    assert outcome.code == 0
    assert outcome.out.startswith(f"{len(rows)} frames: ")
    assert outcome.err.startswith("note: ")


def test_the_frames_before_the_damage_are_used_and_the_damage_is_reported(command, unlabelled):
    Path("pictures/frame_000002.png").write_bytes(b"garbage")
    outcome = command("track", unlabelled, "--output", "out", *TABLE_ALONE)
    outcome.assert_broken_off(2, "frame_000002.png")
    assert len(read_estimates(Path("out/estimates.csv"))) == 2


def test_unreadable_instruments_are_reported_once(command):
    factory = RosbagsMessages()
    with BagWriter(Path("dive")) as writer:
        for frame in small_dive(3, 0.5):
            header = make_header(factory, frame.stamp, "camera")
            message = make_image(factory, frame.image, header)
            writer.write("/image", "sensor_msgs/msg/Image", message, frame.stamp)
            writer.write_serialised(
                "/altitude", "sensor_msgs/msg/Range", b"\x00\x01\x00\x00\x07", frame.stamp
            )
    result = command("track", "dive", *TABLE_ALONE)
    assert result.code == 0
    assert result.err.count("/altitude: 3 of its messages cannot be read") == 1


def test_bad_frames_are_passed_over_where_that_is_wanted(command, unlabelled):
    Path("pictures/frame_000001.png").write_bytes(b"garbage")
    outcome = command("track", unlabelled, "--skip-bad-frames", *TABLE_ALONE)
    assert outcome.code == 0
    statuses = [row.status for row in read_estimates(Path("pictures_tracked/estimates.csv"))]
    assert [status == "REFUSED" for status in statuses] == [False, True, False]
    assert "1 of 3 frames refused; the first, frame 1: " in outcome.err
    assert "taken to be 25 a second (--rate)" in outcome.out


def test_a_recording_without_a_usable_frame_is_refused(command, unlabelled):
    for picture in Path("pictures").glob("*.png"):
        picture.write_bytes(b"garbage")
    outcome = command("track", unlabelled, "--skip-bad-frames")
    outcome.assert_refused("none of the 3 frames can be used; record it again. The first one:")
    assert not Path("pictures_tracked").exists()


def test_a_parameter_file_may_name_preset_and_initial_state_as_for_the_node(command, bag):
    text = "/**:\n  ros__parameters:\n    preset: thesis\n    initial_state: '1,0.1,20,0.01'\n"
    Path("node.yaml").write_text(text)
    table = ("--no-timing", *TABLE_ALONE)
    command("track", bag, "--params", "node.yaml", *table, "--output", "by_file")
    options = ("--preset", "thesis", "--init", "1,0.1,20,0.01")
    command("track", bag, *options, *table, "--output", "by_options")
    tables = [Path(name, "estimates.csv").read_bytes() for name in ("by_file", "by_options")]
    assert tables[0] == tables[1]
    both = command("track", bag, "--params", "node.yaml", "--preset", "default", *table, "--force")
    assert "note: the preset thesis is used" in both.err
    assert Path("dive_tracked/estimates.csv").read_bytes() == tables[0]


@pytest.mark.parametrize("detector", ["hough", "lsd"])
def test_a_detector_can_say_where_to_start(command, detector):
    command("simulate", "clear", "--frames", 3, "--clutter", 0.1, "--size", "160x120")
    outcome = command("track", "clear", "--init", detector, *TABLE_ALONE)
    assert outcome.code == 0
    rows = read_estimates(Path("clear_tracked/estimates.csv"))
    assert rows[0].status == "TRACKING"


def test_a_detector_that_sees_nothing_is_no_start(command):
    Path("dark").mkdir()
    cv2.imwrite("dark/0.png", np.zeros((48, 64), np.uint8))
    command("track", "dark", "--init", "lsd").assert_refused("the detector lsd sees no cable")


HALTING = """
import time
from cable_tracker.cli import main
from cable_tracker.offline.cable_folder import CableFolder

add = CableFolder.add

def add_and_halt(*words, **named):
    add(*words, **named)
    time.sleep(3600)

CableFolder.add = add_and_halt
main()
"""
"""The command line, which comes no further than the first frame: it must not end too early."""


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)]
)
def test_a_signal_leaves_nothing_half_written(unlabelled, tmp_path, number):
    command = [sys.executable, "-c", HALTING, "track", "pictures"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        partial = tmp_path / ".pictures_tracked.partial"
        while process.poll() is None and not partial.exists():
            time.sleep(0.02)
        process.send_signal(number)
        _, errors = process.communicate(timeout=300)
    assert process.returncode == 128 + number
    assert errors.strip().endswith("stopped; nothing was written")
    assert not partial.exists()
    assert not (tmp_path / "pictures_tracked").exists()
