"""Labelled pictures made harder."""

import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.learning_sources import faded, made_harder
from cable_tracker.simulation.worlds.strip import pixel_grid, view_strip

SIZE = (320, 240)
CABLE = CableState(12.0, 0.3, 40.0, 0.06)


@pytest.fixture
def strip():
    """A bright strip on a plain ground."""
    view = view_strip(CABLE.to_array(), *pixel_grid(SIZE))
    cover = np.clip((1 - np.abs(view.u)) * view.radius + 0.5, 0.0, 1.0)
    return np.asarray(80.0 + 100.0 * cover, np.float32)


@pytest.fixture
def picture(strip):
    """The same on a ground that grows brighter to the right."""
    return strip + np.linspace(0.0, 30.0, SIZE[0], dtype=np.float32)


def places() -> tuple[np.ndarray, np.ndarray]:
    """Which pixels lie in the middle of the cable, and which clear of it."""
    u = np.abs(view_strip(CABLE.to_array(), *pixel_grid(SIZE)).u)
    return u < 0.8, u > 1.3


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5])
def test_the_cable_keeps_a_share_of_its_contrast_and_the_bottom_stays(picture, share):
    inside, outside = places()
    result = faded(picture, CABLE, share)
    np.testing.assert_array_equal(result[outside], picture[outside])
    ramp = np.broadcast_to(np.linspace(0.0, 30.0, SIZE[0]), result.shape)
    step = (result - ramp)[inside] - 80.0
    assert step.mean() == pytest.approx(100.0 * share, abs=3.0)
    assert np.abs(step - 100.0 * share).max() < 15.0


def test_with_all_of_its_contrast_it_stays_as_it_is(picture):
    np.testing.assert_allclose(faded(picture, CABLE, 1.0), picture, atol=1e-4)


def test_a_cable_that_is_gone_leaves_no_border(strip):
    assert np.abs(faded(strip, CABLE, 0.0) - 80.0).max() < 1.0


def test_a_cable_beside_the_picture_changes_nothing(picture):
    np.testing.assert_array_equal(faded(picture, CableState(900.0, 0.0, 20.0), 0.0), picture)


def test_harder_pictures_of_eight_bits_hold_whole_levels(picture):
    levels = np.clip(picture, 0, 255).astype(np.uint8)
    first, again, other = (
        made_harder(levels, CABLE, np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()
    np.testing.assert_array_equal(first, np.clip(np.rint(first), 0, 255))
