import math
from types import SimpleNamespace

import numpy as np
import pytest

from cable_tracker.target.poses.pose_belief import (
    HELD_GAIN,
    RIVAL_FRAMES,
    RIVAL_TIME,
    PoseBelief,
    RivalWatch,
    are_beside,
)

TOUCHING, APART = np.array([0.2, 1.5]), np.array([0.2, 2.3])
"""The target at its place, and one of its kind beside it."""


def watched(*frames):
    watch = RivalWatch()
    for distances in frames:
        watch = watch.aged(0.04).after(distances)
    return watch


@pytest.mark.parametrize(
    ("distances", "beside"),
    [
        ([0.2, 1.5], True),
        ([0.2, 1.0], False),
        ([0.2, 3.0], False),
        ([1.5, 2.0], False),
        ([], False),
    ],
)
def test_one_is_beside_another_only_where_both_are_seen(distances, beside):
    assert are_beside(np.array(distances)) is beside


def test_a_rival_is_near_when_both_were_seen_in_some_frames_in_a_row():
    assert not watched(*[TOUCHING] * (RIVAL_FRAMES - 1)).is_near
    watch = watched(*[TOUCHING] * RIVAL_FRAMES)
    assert watch.is_near and not watch.is_merged
    assert watch.gain_factor == HELD_GAIN


def test_a_frame_without_it_counts_from_the_beginning():
    frames = [*[TOUCHING] * (RIVAL_FRAMES - 1), np.array([0.2]), TOUCHING]
    assert not watched(*frames).is_near


def test_one_that_goes_out_of_sight_beside_the_target_is_taken_for_one_with_it_for_a_while():
    watch = watched(*[TOUCHING] * RIVAL_FRAMES).aged(0.04)
    assert watch.is_merged
    assert watch.gain_factor == 0.0
    assert watch.sharpness_factor < 1.0
    assert not watch.aged(RIVAL_TIME).is_near


def test_one_that_was_last_seen_farther_away_has_not_merged():
    assert watched(*[TOUCHING] * RIVAL_FRAMES, APART).since == math.inf


def test_without_a_rival_everything_is_as_usual():
    watch = RivalWatch()
    assert (watch.gain_factor, watch.sharpness_factor, watch.jump_factor) == (1.0, 1.0, 1.0)


def test_the_size_follows_the_scale():
    known = SimpleNamespace(template=SimpleNamespace(size=20.0))
    estimate = np.array([3.0, 4.0, math.log(2.0), 0.1, 0.0, 0.0])
    belief = PoseBelief(particles=None, estimate=estimate, presence=1.0, known=known, rivals=None)
    assert belief.size == pytest.approx(40.0)
