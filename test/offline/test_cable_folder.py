from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from estimate_reader import read_estimates
from rosbags.highlevel import AnyReader

from cable_tracker.errors import OutputError
from cable_tracker.offline import cable_folder, results
from cable_tracker.offline.cable_folder import CableFolder
from cable_tracker.offline.results import WantedResults
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.visualisation.video import VideoWriter

NAMES = {"estimates.csv", "overlay.webm", "overlay.png", "estimates.png", "bag"}


def tracking_row(frame) -> EstimateRow:
    return EstimateRow(
        frame.index,
        frame.stamp,
        "TRACKING",
        state=frame.truth,
        sigma=(1.0, 0.01, 1.0, 0.01),
        n_eff=100.0,
        ms=1.5,
    )


def cloud_of(frame) -> np.ndarray:
    return np.tile([*frame.truth.to_array(), 0.1], (10, 1))


def fill(results, frames) -> None:
    for frame in frames:
        results.add(frame, tracking_row(frame), cloud_of(frame))


def names_in(folder) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.fixture(scope="module")
def filled(tmp_path_factory, dive) -> Path:
    """A folder of results of the dive, to be read only."""
    parent = tmp_path_factory.mktemp("results")
    with CableFolder(parent / "out") as results:
        assert names_in(parent) == {".out.partial"}
        fill(results, dive)
    return parent / "out"


def test_results_appear_together_under_their_names(filled):
    assert names_in(filled.parent) == {"out"}
    assert names_in(filled) == NAMES


def test_the_table_has_a_row_for_each_frame(filled, dive):
    assert read_estimates(filled / "estimates.csv") == [tracking_row(frame) for frame in dive]


def test_the_video_has_a_picture_for_each_frame(filled):
    with av.open(str(filled / "overlay.webm")) as video:
        shapes = [picture.to_ndarray(format="bgr24").shape for picture in video.decode(video=0)]
    assert len(shapes) == 12
    assert len(set(shapes)) == 1
    assert shapes[0][1] >= 480


@pytest.mark.parametrize("name", ["overlay.png", "estimates.png"])
def test_pictures_show_something(filled, name):
    assert cv2.imread(str(filled / name)).std() > 5


def test_the_bag_can_be_read(filled):
    with AnyReader([filled / "bag"]) as reader:
        assert reader.message_count == 0


@pytest.mark.parametrize(
    ("wanted", "missing"),
    [
        (WantedResults(video=False), {"overlay.webm"}),
        (WantedResults(bag=False), {"bag"}),
        (WantedResults(pictures=False), {"overlay.png", "estimates.png"}),
        (WantedResults(False, False, False), NAMES - {"estimates.csv"}),
    ],
)
def test_unwanted_results_are_not_written(tmp_path, dive, wanted, missing):
    with CableFolder(tmp_path / "out", wanted=wanted) as results:
        fill(results, dive[:2])
        results.bag.write_serialised("/state", "std_msgs/msg/Empty", b"\0\1\0\0", 1)
    assert names_in(tmp_path / "out") == NAMES - missing
    assert set(results.names) == NAMES - missing


def test_a_disk_that_fills_up_during_the_video_is_reported(tmp_path, dive, monkeypatch):
    def refuse(writer, image, stamp):
        raise OutputError("overlay.webm: cannot be written (No space left on device)")

    monkeypatch.setattr(VideoWriter, "add", refuse)
    with (
        pytest.raises(OutputError, match="No space left on device"),
        CableFolder(tmp_path / "out") as results,
    ):
        fill(results, dive)
    assert names_in(tmp_path) == set()


def test_large_frames_are_shrunk_in_the_video(tmp_path, dive):
    large = raw_from_array(np.zeros((720, 1280), np.uint8), "mono8")
    with CableFolder(tmp_path / "out") as results:
        fill(results, [replace(dive[0], image=large)])
    with av.open(str(tmp_path / "out" / "overlay.webm")) as video:
        (picture,) = (picture.to_ndarray(format="bgr24") for picture in video.decode(video=0))
    assert picture.shape == (540, 960, 3)


def test_truths_are_kept_by_frame_number(tmp_path, dive):
    with CableFolder(tmp_path / "out") as results:
        fill(results, dive[3:5])
    assert results.truths == {3: dive[3].truth, 4: dive[4].truth}


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, OutputError])
def test_an_exception_leaves_nothing_behind(tmp_path, dive, error):
    with pytest.raises(error), CableFolder(tmp_path / "out") as results:
        fill(results, dive[:2])
        raise error
    assert names_in(tmp_path) == set()


def test_a_run_without_a_picture_leaves_nothing_behind(tmp_path, dive, undecodable):
    with pytest.raises(OutputError), CableFolder(tmp_path / "out") as results:
        results.add(undecodable(dive[0]), EstimateRow(0, 0, "REFUSED"), None)
    assert names_in(tmp_path) == set()


def test_refused_frames_stand_in_the_table_and_not_in_the_video(tmp_path, dive, undecodable):
    with CableFolder(tmp_path / "out") as results:
        fill(results, dive[:2])
        results.add(undecodable(dive[2]), EstimateRow(2, dive[2].stamp, "REFUSED"), None)
    assert [row.status for row in results.rows] == ["TRACKING", "TRACKING", "REFUSED"]
    with av.open(str(tmp_path / "out" / "overlay.webm")) as video:
        assert len(list(video.decode(video=0))) == 2


def test_earlier_results_outlive_a_failed_run(tmp_path, dive):
    with CableFolder(tmp_path / "out") as results:
        fill(results, dive[:1])
    with pytest.raises(RuntimeError), CableFolder(tmp_path / "out", overwrite=True) as results:
        raise RuntimeError
    assert len(read_estimates(tmp_path / "out" / "estimates.csv")) == 1
    assert names_in(tmp_path) == {"out"}


def test_an_empty_folder_may_be_filled(tmp_path, dive):
    (tmp_path / "out").mkdir()
    with CableFolder(tmp_path / "out", overwrite=True) as results:
        fill(results, dive[:1])
    assert names_in(tmp_path / "out") == NAMES


@pytest.mark.parametrize("name", ["write_estimates", "plot_estimates"])
def test_a_disk_that_is_full_at_the_end_is_reported_in_one_line(
    tmp_path, dive, monkeypatch, full_disk, name
):
    monkeypatch.setattr(cable_folder, name, full_disk)
    with (
        pytest.raises(OutputError, match="No space left on device") as caught,
        CableFolder(tmp_path / "out") as results,
    ):
        fill(results, dive[:1])
    assert "\n" not in str(caught.value)
    assert names_in(tmp_path) == set()


@pytest.mark.parametrize(("module", "name"), [(results, "BagWriter"), (results, "VideoWriter")])
def test_a_disk_that_is_full_at_the_start_is_reported_in_one_line(
    tmp_path, monkeypatch, full_disk, module, name
):
    monkeypatch.setattr(module, name, full_disk)
    with (
        pytest.raises(OutputError, match="No space left on device"),
        CableFolder(tmp_path / "out"),
    ):
        pass
    assert names_in(tmp_path) == set()


def test_an_interrupt_at_the_start_is_not_hidden_by_another_error(tmp_path, monkeypatch):
    def stopped():
        raise KeyboardInterrupt

    # By then the video is open, and has no frames.
    monkeypatch.setattr(cable_folder, "DrawingThread", stopped)
    with pytest.raises(KeyboardInterrupt), CableFolder(tmp_path / "out"):
        pass
    assert names_in(tmp_path) == set()


def test_a_video_that_cannot_be_begun_leaves_nothing_behind(tmp_path, monkeypatch):
    def refuse(path):
        raise OutputError(f"{path}: videos need PyAV")

    monkeypatch.setattr(results, "VideoWriter", refuse)
    with pytest.raises(OutputError, match="PyAV"), CableFolder(tmp_path / "out"):
        pass
    assert names_in(tmp_path) == set()


def test_a_file_of_the_user_among_earlier_results_is_not_lost(tmp_path, dive):
    for _ in range(2):
        with CableFolder(tmp_path / "out", overwrite=True) as results:
            fill(results, dive[:2])
    (tmp_path / "out" / "tracker.yaml").write_text("mine")
    with (
        pytest.raises(OutputError, match=r"out/tracker\.yaml: .* move it elsewhere"),
        CableFolder(tmp_path / "out", overwrite=True),
    ):
        pass
    assert names_in(tmp_path / "out") == {*NAMES, "tracker.yaml"}
