"""Motion of the cable in worlds."""

import numpy as np
import pytest

from cable_tracker.cable.model.state import DEGREE, POSE_COMPONENTS
from cable_tracker.simulation.worlds.motion import MotionKind, random_motion
from cable_tracker.tracking.robust import GAUSSIAN_MAD

UNITS = np.array([each.factor for each in POSE_COMPONENTS])


def inspections(count: int = 120) -> list[np.ndarray]:
    """Return motions of pipes as inspections see them."""
    return [
        random_motion(MotionKind.INSPECTION, None, (-35.0, 35.0), 250, np.random.default_rng(seed))
        for seed in range(count)
    ]


def test_steps_of_inspections_are_small_with_heavy_tails():
    steps = np.concatenate([np.diff(each[:, :4], axis=0) for each in inspections()]) * UNITS
    spread = GAUSSIAN_MAD * np.median(np.abs(steps), axis=0)
    tails = np.quantile(np.abs(steps), 0.995, axis=0)
    np.testing.assert_allclose(spread, (0.17, 0.05, 0.13, 0.03), rtol=0.3)
    np.testing.assert_allclose(tails, (1.5, 0.6, 1.3, 0.5), rtol=0.5)


def test_pipes_of_inspections_are_wide_and_skewed():
    states = np.concatenate(inspections(400))
    width, skew = states[:, 2], np.abs(states[:, 3]) * DEGREE
    assert np.mean(width > 120) == pytest.approx(0.42, abs=0.12)
    assert np.mean(width > 160) == pytest.approx(0.12, abs=0.08)
    assert np.mean(skew > 10) > 0.75
    assert np.mean(skew > 15) == pytest.approx(0.5, abs=0.12)


@pytest.mark.parametrize("kind", MotionKind)
def test_rates_are_the_slope_of_the_motion(kind):
    states = random_motion(kind, (20.0, 60.0), (-35.0, 35.0), 60, np.random.default_rng(2))
    central = (states[2:, :4] - states[:-2, :4]) * 12.5
    np.testing.assert_allclose(states[1:-1, 4:], central, atol=1e-9)


def apexes(states: np.ndarray) -> np.ndarray:
    """Return where borders meet, shape (N, 2) [px]."""
    distance, angle, width, skew = states[:, :4].T
    along = width / (2 * np.tan(skew))
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack((distance * cos - along * sin, distance * sin + along * cos), axis=1)


@pytest.mark.parametrize("kind", MotionKind)
@pytest.mark.parametrize("height", [320.0, 427.0, 570.0])
def test_borders_meet_outside_of_high_pictures(kind, height):
    for seed in range(40):
        rng = np.random.default_rng(seed)
        states = random_motion(kind, None, (-35.0, 35.0), 100, rng, height=height)
        away = np.abs(apexes(states)) - np.array((320.0, height)) / 2
        assert (away.max(axis=1) > 0.0).all()


def test_pictures_up_to_the_usual_height_have_one_motion():
    usual, lower = (
        random_motion(
            MotionKind.INSPECTION, None, (0.0, 0.0), 60, np.random.default_rng(3), height=height
        )
        for height in (240.0, 120.0)
    )
    assert np.array_equal(usual, lower)


def test_lively_cables_move_more_than_inspected_ones():
    calm, lively = (
        np.mean(
            [
                np.abs(
                    np.diff(
                        random_motion(
                            kind, (30.0, 40.0), (0.0, 0.0), 250, np.random.default_rng(s)
                        )[:, 0]
                    )
                )
                for s in range(20)
            ]
        )
        for kind in (MotionKind.INSPECTION, MotionKind.LIVELY)
    )
    assert lively > 2 * calm
