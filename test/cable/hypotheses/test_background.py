from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from plain_images import plain_image

from cable_tracker.cable.hypotheses.background import (
    SHARED_ANGLE,
    SHARED_OFFSET,
    SMALLEST_DEVIATION,
    Background,
    background_of,
    shares_border,
)
from cable_tracker.cable.hypotheses.frame_inputs import frame_config
from cable_tracker.cable.measure.borders.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.model.geometry import project_borders, states_from_borders
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters

MODEL = BorderLikelihoodRatio(TrackerParameters())
CONFIG = frame_config(TrackerParameters(), 4.0, (320, 240))


@pytest.fixture
def background(frame_inputs):
    """Return the background of poses in a picture."""

    def measure(picture, poses) -> Background:
        means = np.hstack((np.array(poses), np.zeros((len(poses), 4))))
        return background_of(means, frame_inputs(picture), CONFIG)

    return measure


def level_of(picture, pose) -> float:
    image = plain_image(picture.astype(np.float32))
    return float(MODEL.log_likelihoods(np.array([[*pose, 0.0, 0.0, 0.0, 0.0]]), image)[0])


def grain(rng) -> np.ndarray:
    return rng.normal(100.0, 5.0, (240, 320))


def test_a_single_strip_has_no_like_in_the_picture(background, rng):
    picture = grain(rng)
    picture[:, 140:180] += 60.0
    pose = [0.0, 0.0, 40.0, 0.0]
    found = background(picture, [pose])
    assert found.alike[0] < 0.3 * level_of(picture, pose)
    assert level_of(picture, pose) > found.means[0] + 5.0 * found.deviations[0]


def test_one_ripple_of_many_is_explained_by_the_bottom(background, rng):
    stripes = 60.0 * (np.sin(2.0 * np.pi * np.arange(320) / 32.0) > 0.0)
    picture = grain(rng) + stripes
    pose = [8.0 - 160.0 + 0.5 + 160.0, 0.0, 16.0, 0.0]
    found = background(picture, [pose])
    assert found.alike[0] > 0.5 * level_of(picture, pose)


def test_the_bottom_explains_nothing_at_least(background):
    poses = [[0.0, 0.3, 30.0, 0.0], [50.0, 0.0, 9.0, 0.0]]
    found = background(np.full((240, 320), 90.0), poses)
    assert (found.alike >= 0.0).all()
    assert (found.deviations >= SMALLEST_DEVIATION).all()


def test_without_hypotheses_there_is_nothing(background, rng):
    found = background(grain(rng), np.empty((0, 4)))
    assert len(found.alike) == len(found.means) == len(found.deviations) == 0


@pytest.mark.parametrize("count", [1, 3, 5])
def test_each_hypothesis_has_a_background_of_its_own(background, count, rng):
    poses = [[30.0 * index - 60.0, 0.0, 20.0, 0.0] for index in range(count)]
    assert len(background(grain(rng), poses).alike) == count


STRIP = CableState(10.0, 0.3, 40.0, 0.05).to_array()


def beside(gap=0.0, turn=0.0):
    """The strip of 30 px on the right of `STRIP`, its left border so far from the other's."""
    borders = project_borders(STRIP[None])
    borders.angles[0] = borders.angles[0, 1] + turn
    borders.offsets[0] = borders.offsets[0, 1] + gap + np.array([0.0, 30.0])
    state = np.zeros(8)
    state[:4] = states_from_borders(borders)[0]
    return state


def turned_round(state):
    other = state.copy()
    other[[0, 3]] *= -1.0
    other[1] += np.pi
    return other


@pytest.mark.parametrize("write", [np.copy, turned_round], ids=["as it is", "turned round"])
def test_neighbours_have_a_border_in_common(write):
    assert shares_border(write(beside()), STRIP, 1.0)


@given(gap=st.floats(0.0, 20.0), turn=st.floats(0.0, 0.3))
def test_borders_near_each_other_are_one(gap, turn):
    # The gap is along the border's normal, the limit along that of the centreline.
    assume(abs(gap - SHARED_OFFSET) > 0.1)
    assume(abs(turn - SHARED_ANGLE) > 1e-6)
    is_near = gap < SHARED_OFFSET and turn < SHARED_ANGLE
    assert shares_border(beside(gap, turn), STRIP, 1.0) == is_near


def test_a_strip_elsewhere_shares_none():
    assert not shares_border(beside(gap=20.0), STRIP, 1.0)
    assert not shares_border(beside(turn=0.3), STRIP, 1.0)


def test_the_distance_at_which_strips_share_a_border_grows_with_the_picture():
    neighbour = beside(gap=12.0)
    assert not shares_border(neighbour, STRIP, 1.0)
    assert shares_border(neighbour, STRIP, 2.0)
