from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.errors import FrameError
from cable_tracker.gui.session.session_trackers import CableSessionTracker, TargetSessionTracker
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.labels.target_labels import BoxTruth
from cable_tracker.sequences.pictures.shown_levels import DARK, STAND_IN_SIZE
from cable_tracker.sequences.source import open_source
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters

PARAMETERS = TrackerParameters(particle_count=120, seed=4)
THIN = {
    "initial_width_minimum": 4.0,
    "width_minimum": 4.0,
    "initial_width_maximum": 20.0,
    "width_maximum": 25.0,
}
NONE_SO_WIDE = {
    "width_maximum": 190.0,
    "initial_width_maximum": 180.0,
    "initial_width_minimum": 170.0,
    "width_minimum": 160.0,
}


@pytest.fixture
def source(tmp_path):
    """An open recording that shows a wide cable beside a thin one."""
    grain = np.random.default_rng(0).integers(0, 25, (240, 320)).astype(np.uint8)
    picture = np.full((240, 320), 90, np.uint8) + grain
    cv2.line(picture, (80, -5), (80, 245), 190, 50)
    cv2.line(picture, (240, -5), (250, 245), 190, 12)
    assert cv2.imwrite(str(tmp_path / "0.png"), picture)
    with open_source(tmp_path) as opened:
        yield opened


def first_snapshot(tracker, source):
    """Begin a run, and track its first frame."""
    tracker.reset()
    tracker.begin()
    frame = next(source.frames())
    tracker.decode(frame)
    return tracker.follow(frame, 1)


def test_a_run_starts_from_what_the_detector_sees_under_the_parameters_in_force(source):
    tracker = CableSessionTracker(source, "hough", PARAMETERS, None)
    wide = first_snapshot(tracker, source)
    tracker.configure(THIN)
    thin = first_snapshot(tracker, source)
    fresh = CableSessionTracker(source, "hough", PARAMETERS.replaced(THIN), None)
    assert np.array_equal(thin.cloud, first_snapshot(fresh, source).cloud)
    assert np.median(thin.cloud[:, 2]) < 25.0 < np.median(wide.cloud[:, 2])


def test_where_the_detector_sees_no_cable_any_more_it_is_said_and_the_run_goes_on(source):
    tracker = CableSessionTracker(source, "hough", PARAMETERS, None)
    tracker.configure(NONE_SO_WIDE)
    assert first_snapshot(tracker, source).cloud is not None
    assert "hough sees no cable" in tracker.trouble
    first_snapshot(tracker, source)
    assert "hough sees no cable" in tracker.trouble
    tracker.reset()
    assert not tracker.trouble
    tracker.configure(THIN)
    first_snapshot(tracker, source)
    assert not tracker.trouble


def test_one_that_is_remembered_does_not_keep_the_picture_of_its_frame():
    tracker = TargetSessionTracker("wait", TargetParameters(), BoxTruth(), None)
    frame = Frame(0, 1_000_000_000, raw_from_array(np.zeros((600, 800, 3), np.uint8), "bgr8"))
    tracker.decode(frame)
    remembered = tracker.copy()
    assert remembered.show(frame, 1, "").image.shape[:2] == STAND_IN_SIZE[::-1]
    assert tracker.show(frame, 1, "").image.shape[:2] == (600, 800)
    remembered.decode(frame)
    assert remembered.follow(frame, 2).image.shape[:2] == (600, 800)


def test_of_a_frame_that_cannot_be_decoded_the_picture_before_is_not_shown():
    tracker = TargetSessionTracker("wait", TargetParameters(), BoxTruth(), None)
    frame = Frame(0, 1_000_000_000, raw_from_array(np.zeros((600, 800, 3), np.uint8), "bgr8"))
    tracker.decode(frame)
    bad = replace(frame, index=1, image=replace(frame.image, encoding="nv12"))
    with pytest.raises(FrameError, match="nv12"):
        tracker.decode(bad)
    shown = tracker.show(bad, 2, "REFUSED").image
    assert shown.shape[:2] == (600, 800)
    assert (shown == DARK).all()


def test_a_box_is_checked_against_the_last_picture_that_could_be_decoded():
    tracker = TargetSessionTracker("wait", TargetParameters(), BoxTruth(), None)
    frame = Frame(0, 1_000_000_000, raw_from_array(np.zeros((600, 800, 3), np.uint8), "bgr8"))
    tracker.decode(frame)
    with pytest.raises(FrameError):
        tracker.decode(replace(frame, image=replace(frame.image, encoding="nv12")))
    tracker.initialise(TargetStart.from_box(600, 400, 700, 500))
