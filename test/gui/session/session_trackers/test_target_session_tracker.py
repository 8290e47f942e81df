from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cable_tracker.errors import FrameError
from cable_tracker.gui.session.session_trackers.target_session_tracker import TargetSessionTracker
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.labels.target_labels import BoxTruth
from cable_tracker.sequences.pictures.shown_levels import DARK, STAND_IN_SIZE
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.parameters.parameters import TargetParameters


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
