import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from cable_tracker.cli import app
from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.simulation.scenarios.scenario_dive import SimulationSettings, simulate


def run(*arguments):
    return CliRunner().invoke(app, ["dev", "estimate-noise", *map(str, arguments)])


@pytest.fixture(scope="module")
def frames():
    return tuple(simulate(SimulationSettings(frame_count=6, image_size=(64, 48))))


@pytest.fixture
def labels(tmp_path, frames):
    write_sequence(tmp_path / "dive", frames)
    (path,) = (tmp_path / "dive").glob("*.txt")
    return path


def test_the_variances_of_a_labelled_sequence_are_printed(labels):
    result = run(labels)
    assert result.exit_code == 0
    assert "6 of 6 frames labelled, 5 steps of 0.04 s" in result.stdout
    assert all(unit in result.stdout for unit in ("w [px²]", "beta [deg²]", "alpha [deg²]"))


def test_a_recording_without_labels_says_what_to_do(labels):
    pictures = next(path.parent for path in labels.parent.rglob("*.png"))
    result = run(pictures)
    assert "0 of 6 frames are labelled" in str(result.exception)
    assert "--truth FILE" in str(result.exception)


def test_a_label_that_fits_no_frame_is_named(labels):
    pictures = next(path.parent for path in labels.parent.rglob("*.png"))
    with labels.open("a") as file:
        file.write("1 0 30 0 # nowhere.png\n")
    assert "labels nowhere.png" in str(run(pictures, "--truth", labels).exception)


def test_steps_across_frames_without_a_label_do_not_count(labels, tmp_path):
    pictures = next(path.parent for path in labels.parent.rglob("*.png"))
    lines = labels.read_text().splitlines()
    some = tmp_path / "some.txt"
    some.write_text("\n".join(lines[:4] + lines[5:]) + "\n")
    assert "5 of 6 frames labelled, 3 steps" in run(pictures, "--truth", some).stdout


def write_video(path, count, rate=25.0, size=(64, 48)):
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), rate, size)
    for _ in range(count):
        writer.write(np.full((*size[::-1], 3), 90, np.uint8))
    writer.release()


def variances_of(stdout, row):
    """Of w, beta, d, alpha, in a row of the printed table."""
    (line,) = [line for line in stdout.splitlines() if row in line and "│" in line]
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
def test_what_parameters_would_say_does_not_depend_on_size_and_rate_of_the_pictures(
    tmp_path, scale, rate
):
    said = run(labelled_video(tmp_path, scale, rate)).stdout
    w, _, d, _ = variances_of(said, "recording")
    per_frame = scale**2 * 25.0 / rate
    in_parameters = variances_of(said, "parameters")
    assert in_parameters[0] == pytest.approx(w / per_frame, rel=1e-3)
    assert in_parameters[2] == pytest.approx(d / per_frame, rel=1e-3)
    assert "px of a picture of 320 px width, per frame of 0.04 s" in said.replace("\n", " ")


def test_pictures_that_cannot_be_decoded_are_as_wide_as_those_before(labels):
    whole = variances_of(run(labels).stdout, "parameters")
    last = sorted(labels.parent.rglob("*.png"))[-1]
    last.write_bytes(last.read_bytes()[:100])
    damaged = run(labels, "--skip-bad-frames")
    assert variances_of(damaged.stdout, "parameters") == whole


def test_a_step_from_one_recording_of_a_list_to_the_next_does_not_count(tmp_path):
    lines = []
    for name in ("one.avi", "other.avi"):
        write_video(tmp_path / name, 6)
        lines += [f"{number} 0 12 0 # {name}:{number}" for number in range(6)]
    (tmp_path / "both.txt").write_text("\n".join(lines) + "\n")
    assert "12 of 12 frames labelled, 10 steps of 0.04 s" in run(tmp_path / "both.txt").stdout


def test_a_step_over_frames_that_are_missing_does_not_count(labels):
    lines = labels.read_text().splitlines()
    labels.write_text("\n".join(lines[:4] + lines[5:]) + "\n")
    assert "5 of 5 frames labelled, 3 steps of 0.04 s" in run(labels).stdout
