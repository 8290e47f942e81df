from functools import partial

import cv2
import numpy as np
import pytest

from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate


@pytest.fixture
def run(command):
    return partial(command, "dev", "estimate-noise")


@pytest.fixture(scope="module")
def frames():
    return tuple(simulate(SimulationSettings(frame_count=6, image_size=(64, 48))))


@pytest.fixture
def labels(tmp_path, frames):
    write_sequence(tmp_path / "dive", frames)
    (path,) = (tmp_path / "dive").glob("*.txt")
    return path


def test_the_variances_of_a_labelled_sequence_are_printed(run, labels):
    result = run(labels)
    assert result.code == 0
    assert "6 of 6 frames labelled, 5 steps of 0.04 s" in result.out
    assert all(unit in result.out for unit in ("w [px²]", "beta [deg²]", "alpha [deg²]"))


def test_a_recording_without_labels_is_refused_with_a_remedy(run, labels):
    pictures = next(path.parent for path in labels.parent.rglob("*.png"))
    code, _, told = run(pictures)
    assert code == 2
    assert "0 of 6 frames are labelled" in told and "--truth FILE" in told


def test_a_label_that_fits_no_frame_is_named(run, labels):
    pictures = next(path.parent for path in labels.parent.rglob("*.png"))
    with labels.open("a") as file:
        file.write("1 0 30 0 # nowhere.png\n")
    run(pictures, "--truth", labels).assert_refused("labels nowhere.png")


def write_video(path, count, rate=25.0, size=(64, 48)):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), rate, size)
    for _ in range(count):
        writer.write(np.full((*size[::-1], 3), 90, np.uint8))
    writer.release()


def variances_of(out, row):
    """Of w, beta, d, alpha, in a row of the printed table."""
    (line,) = [line for line in out.splitlines() if row in line and "│" in line]
    return [float(cell) for cell in line.split("│")[2:-1]]


def labelled_video(tmp_path, scale, rate):
    """The same dive in pictures of `scale` times the reference width."""
    rng = np.random.default_rng(5)
    write_video(tmp_path / "dive.avi", 8, rate, (320 * scale, 240 * scale))
    d, w = scale * rng.normal(0.0, 3.0, 8), scale * rng.uniform(20.0, 30.0, 8)
    lines = [f"{d[k]} 0.1 {w[k]} 0.0 # dive.avi:{k}" for k in range(8)]
    (tmp_path / "dive.txt").write_text("\n".join(lines) + "\n")
    return tmp_path / "dive.txt"


@pytest.mark.parametrize(("scale", "rate"), [(2, 25.0), (1, 12.5)])
def test_variances_as_parameters_do_not_depend_on_picture_size_and_frame_rate(
    run, tmp_path, scale, rate
):
    said = run(labelled_video(tmp_path, scale, rate)).out
    w, _, d, _ = variances_of(said, "recording")
    per_frame = scale**2 * 25.0 / rate
    in_parameters = variances_of(said, "parameters")
    assert in_parameters[0] == pytest.approx(w / per_frame, rel=1e-3)
    assert in_parameters[2] == pytest.approx(d / per_frame, rel=1e-3)
    assert "px of a picture of 320 px width, per frame of 0.04 s" in said.replace("\n", " ")


def test_pictures_that_cannot_be_decoded_are_as_wide_as_those_before(run, labels):
    whole = variances_of(run(labels).out, "parameters")
    last = sorted(labels.parent.rglob("*.png"))[-1]
    last.write_bytes(last.read_bytes()[:100])
    damaged = run(labels, "--skip-bad-frames")
    assert variances_of(damaged.out, "parameters") == whole


def test_a_step_from_one_recording_of_a_list_to_the_next_does_not_count(run, tmp_path):
    lines = []
    for name in ("one.avi", "other.avi"):
        write_video(tmp_path / name, 6)
        lines += [f"{number} 0 12 0 # {name}:{number}" for number in range(6)]
    (tmp_path / "both.txt").write_text("\n".join(lines) + "\n")
    assert "12 of 12 frames labelled, 10 steps of 0.04 s" in run(tmp_path / "both.txt").out
