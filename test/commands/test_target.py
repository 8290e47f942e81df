import csv
import shutil
from functools import partial

import cv2
import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from cable_tracker.offline.target_table import HEADER
from cable_tracker.sequences.bags.rosbags_messages import typestore
from cable_tracker.simulation.targets.sequence import simulate_target


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("dive")
    for index, frame in enumerate(simulate_target("near_surface", 2, 8)):
        cv2.imwrite(str(path / f"{index:03}.png"), frame.image)
    return path


@pytest.fixture(scope="module")
def first_box():
    return next(simulate_target("near_surface", 2, 8)).box


@pytest.fixture
def run(command):
    return partial(command, "target")


def table(path):
    with (path / "estimates.csv").open(newline="") as file:
        return list(csv.reader(file))


def test_a_marked_target_is_followed_into_a_folder(run, folder, first_box, tmp_path):
    words = ",".join(str(side) for side in first_box)
    result = run(folder, "--init", words, "--output", tmp_path / "out")
    assert result.code == 0, result.err
    assert "8 frames: 8 TRACKING" in result.out
    lines = table(tmp_path / "out")
    assert tuple(lines[0]) == HEADER
    assert ",".join(lines[0]) == (
        "frame,stamp,status,x,y,scale,angle,v_x,v_y,sigma_x,sigma_y,box_x0,box_y0,box_x1,box_y1,"
        "area,presence,n_eff,ms,event"
    )
    box = [float(cell) for cell in lines[1][11:15]]
    assert box == pytest.approx(first_box, abs=6.0)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "estimates.csv", "overlay.webm", "overlay.png", "bag",
    }  # fmt: skip


def test_a_target_within_a_few_levels_of_a_deep_camera_is_followed(run, first_box, tmp_path):
    (tmp_path / "dim").mkdir()
    for index, frame in enumerate(simulate_target("near_surface", 2, 4)):
        # 10 bits that are sent in 16.
        cv2.imwrite(str(tmp_path / "dim" / f"{index}.png"), 4 * frame.image.astype(np.uint16))
    words = ",".join(str(side) for side in first_box)
    options = ("--no-bag", "--no-video", "--output", tmp_path / "out")
    result = run(tmp_path / "dim", "--init", words, *options)
    assert "4 frames: 4 TRACKING" in result.out
    assert cv2.imread(str(tmp_path / "out" / "overlay.png")).mean() > 60


def test_the_table_has_the_reasons_for_refused_frames_and_restarts(
    run, folder, first_box, tmp_path
):
    dive = tmp_path / "dive"
    dive.mkdir()
    for index, path in enumerate(sorted(folder.iterdir())):
        shutil.copy(path, dive / f"{index if index < 6 else index + 194}.png")
    (dive / "2.png").write_bytes(b"no picture")
    words = ",".join(str(side) for side in first_box)
    result = run(dive, "--init", words, "--skip-bad-frames", "--output", tmp_path / "out")
    assert result.code == 0, result.err
    events = [line[-1] for line in table(tmp_path / "out")[1:]]
    refusal = "the data is no picture: neither JPEG, PNG, BMP, TIFF nor PNM by its first bytes"
    assert events == ["", "", refusal, "", "", "", "no frame for 7.800 s", ""]


def test_without_a_bag_no_messages_are_made(run, folder, first_box, tmp_path, monkeypatch):
    def encode_jpeg(picture):
        raise AssertionError("no picture is encoded where no bag is wanted")

    monkeypatch.setattr("cable_tracker.sequences.bags.frame_messages.encode_jpeg", encode_jpeg)
    words = ",".join(str(side) for side in first_box)
    result = run(folder, "--init", words, "--no-bag", "--output", tmp_path / "out")
    assert result.code == 0, result.err
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "estimates.csv", "overlay.webm", "overlay.png",
    }  # fmt: skip


def test_only_the_table_is_written_and_printed_when_only_it_is_wanted(
    run, folder, first_box, tmp_path
):
    words = ",".join(str(side) for side in first_box)
    nothing_else = ("--no-bag", "--no-video", "--no-pictures")
    result = run(folder, "--init", words, *nothing_else, "--output", tmp_path / "out")
    assert result.code == 0, result.err
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["estimates.csv"]
    assert "estimates.csv" in result.out and "overlay" not in result.out


def test_a_detector_proposes_and_the_same_seed_gives_the_same_table(run, folder, tmp_path):
    for name in ("one", "two"):
        result = run(folder, "--init", "detect", "--no-timing", "--output", tmp_path / name)
        assert result.code == 0, result.err
    assert (tmp_path / "one" / "estimates.csv").read_bytes() == (
        tmp_path / "two" / "estimates.csv"
    ).read_bytes()
    assert [line[2] for line in table(tmp_path / "one")][-1] == "TRACKING"


def test_rows_without_a_claim_have_no_state(run, tmp_path):
    (tmp_path / "water").mkdir()
    for index in range(3):
        picture = np.full((120, 160, 3), (90, 80, 40), np.uint8)
        cv2.imwrite(str(tmp_path / "water" / f"{index}.png"), picture)
    result = run(tmp_path / "water", "--output", tmp_path / "out")
    assert result.code == 0, result.err
    assert all(line[3:16] == [""] * 13 for line in table(tmp_path / "out")[1:])


@pytest.mark.parametrize("init", ["here", "1,2,3", "5,5,5,5", "1,2,nan,4", "900,900,950,950"])
def test_a_bad_start_is_refused(run, folder, tmp_path, init):
    run(folder, "--init", init, "--output", tmp_path / "out").assert_refused("init")
    assert not (tmp_path / "out").exists()


def test_a_parameter_file_may_name_the_preset(run, folder, first_box, tmp_path):
    file = tmp_path / "params.yaml"
    file.write_text("target_tracker:\n  ros__parameters:\n    preset: docking\n    seed: 3\n")
    words = ",".join(str(side) for side in first_box)
    result = run(folder, "--init", words, "--params", file, "--output", tmp_path / "out")
    assert result.code == 0, result.err


def test_the_bag_holds_what_the_node_would_publish(run, folder, first_box, tmp_path):
    words = ",".join(str(side) for side in first_box)
    result = run(folder, "--init", words, "--output", tmp_path / "out")
    assert result.code == 0, result.err
    with AnyReader([tmp_path / "out" / "bag"], default_typestore=typestore()) as reader:
        counts = {each.topic: each.msgcount for each in reader.connections}
        boxes = [
            reader.deserialize(data, each.msgtype)
            for each, _, data in reader.messages()
            if each.topic == "/box"
        ]
    assert counts == dict.fromkeys(
        (
            "/state", "/target", "/contour", "/box", "/particles", "/markers",
            "/target_tracker/frame_report", "/target_tracker/overlay/compressed",
        ),
        8,
    )  # fmt: skip
    corner = boxes[0].polygon.points[0]
    assert (corner.x, corner.y) == pytest.approx(first_box[:2], abs=6.0)


@pytest.mark.parametrize("option", ["--target-size", "--vehicle"])
def test_options_for_metres_without_a_calibration_are_noted(run, folder, tmp_path, option):
    vehicle = tmp_path / "vehicle.yaml"
    vehicle.write_text("camera_pitch: 10.0\n")
    value = 0.5 if option == "--target-size" else vehicle
    wanted = ("--no-bag", "--no-video", "--no-pictures")
    result = run(folder, option, value, "--output", tmp_path / "out", *wanted)
    assert result.code == 0, result.err
    assert f"note: {folder}: no metres: there is no calibration" in result.err
    plain = run(folder, "--output", tmp_path / "plain", *wanted)
    assert "no metres" not in plain.err
