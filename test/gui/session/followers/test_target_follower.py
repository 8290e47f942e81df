from __future__ import annotations

import numpy as np

from cable_tracker.gui.session.followers.target_follower import TargetFollower
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.labels.target_labels import BoxTruth
from cable_tracker.sequences.pictures.shown_levels import STAND_IN_SIZE
from cable_tracker.target.parameters.parameters import TargetParameters


def test_one_that_is_remembered_does_not_keep_the_picture_of_its_frame():
    follower = TargetFollower("wait", TargetParameters(), BoxTruth())
    frame = Frame(0, 1_000_000_000, raw_from_array(np.zeros((600, 800, 3), np.uint8), "bgr8"))
    follower.look(frame)
    remembered = follower.copy()
    assert remembered.show(frame, 1, "").image.shape[:2] == STAND_IN_SIZE[::-1]
    assert follower.show(frame, 1, "").image.shape[:2] == (600, 800)
    remembered.look(frame)
    assert remembered.follow(frame, 2).image.shape[:2] == (600, 800)
