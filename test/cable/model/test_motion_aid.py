from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.movement import DOUBT_STRIDE
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.movement import LimitedMovement
from cable_tracker.trackers import CableTracker

FRAME = 40_000_000


class Shift:
    """Odometry that says how far d moves, and nearly all of what there is to know."""

    def __init__(self, pixels: float, sigma: float = 0.01) -> None:
        self._pixels, self._sigma = pixels, sigma

    def moved(self, states):
        moved = states.copy()
        moved[:, 0] += self._pixels
        return moved

    def scales(self):
        return np.full(8, self._sigma)


class Turning(Shift):
    """Odometry that changes every rate."""

    def __init__(self) -> None:
        super().__init__(0.0)

    def moved(self, states):
        moved = states.copy()
        moved[:, 4:] = 3.0
        return moved


STATES = np.tile([5.0, 0.1, 40.0, 0.01, 90.0, 0.0, 0.0, 0.0], (50, 1))


@pytest.fixture
def movement():
    return LimitedMovement(TrackerParameters(), 320)


def test_odometry_moves_cables_in_place_of_their_rates(movement):
    np.testing.assert_allclose(movement.expected(STATES, 0.04, Shift(7.0))[:, 0], 12.0)
    assert (movement.expected(STATES, 0.04)[:, 0] != 12.0).all()


def test_one_particle_in_four_ignores_odometry_and_diffuses_as_without(movement):
    many = np.tile(STATES[0], (40_000, 1))
    usual = movement.expected(many, 0.04)[0, 0]
    rng = np.random.default_rng(1)
    spread = movement.propagate(many, 0.04, rng)[:, 0]
    moved = movement.propagate(many, 0.04, rng, Shift(70.0))[:, 0]
    doubting = np.arange(len(many)) % DOUBT_STRIDE == DOUBT_STRIDE - 1
    assert np.median(moved[~doubting]) == pytest.approx(75.0, abs=0.1)
    assert np.median(moved[doubting]) == pytest.approx(usual, abs=0.1)
    for share in (10, 90):
        expected = np.percentile(spread, share) - usual
        assert np.percentile(moved[doubting], share) - usual == pytest.approx(expected, rel=0.1)


def test_rates_that_the_model_never_changes_are_left_alone():
    """The thesis has none of w and beta; odometry would leave them some that nothing ends."""
    movement = LimitedMovement(preset("thesis"), 320)
    rates = movement.expected(STATES, 0.04, Turning())[0, 4:]
    np.testing.assert_array_equal(rates, [3.0, 3.0, 0.0, 0.0])


def test_odometry_leaves_less_unknown_and_never_more(movement):
    usual = movement.diffusion(0.04).pose_scales
    sure = movement.diffusion(0.04, Shift(0.0, sigma=0.01)).pose_scales
    assert (sure == np.minimum(usual, 0.01)).all()
    unsure = movement.diffusion(0.04, Shift(0.0, sigma=1e6)).pose_scales
    np.testing.assert_array_equal(unsure, usual)


@pytest.mark.parametrize("name", ["default", "thesis"])
def test_both_filters_follow_a_cable_that_odometry_says_has_jumped(name, draw_strip):
    """A jump that no rate and no diffusion would make."""
    errors = []
    for told in (None, Shift(50.0, sigma=1.0)):
        tracker = CableTracker(preset(name).replaced({"seed": 3, "detector": "none"}))
        near = CableState(-30.0, 0.0, 30.0)
        tracker.initialise(GivenState.around(near))
        for index in range(3):
            tracker.process(draw_strip(near), index * FRAME + FRAME)
        after = tracker.process(draw_strip(CableState(20.0, 0.0, 30.0)), 4 * FRAME, told)
        errors.append(abs(after.state.distance - 20.0))
    assert errors[1] < 2.0 < errors[0]


def test_the_aid_of_one_frame_is_not_that_of_the_next(dive):
    frames = dive(frames=8)

    def track(motions):
        tracker = CableTracker(TrackerParameters(seed=1))
        for (picture, stamp, _), motion in zip(frames, motions, strict=True):
            tracker.process(picture, stamp, motion)
        return tracker.particles.states

    plain = track([None] * 8)
    np.testing.assert_array_equal(plain, track([None] * 8))
    # The first frame has none before it: what could have moved?
    np.testing.assert_array_equal(plain, track([Shift(50.0)] + [None] * 7))
    assert not np.array_equal(plain, track([None] * 4 + [Shift(1.0)] + [None] * 3))
