"""What is done to pictures to train on, and to the maps that say where the cable is in them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from map_pictures.camera import warp
from map_pictures.changes import augmented, augmented_scene
from map_pictures.surface import random_pose, true_map

SHAPE = (240, 320)
UPRIGHT = np.array([0.0, 0.0, 60.0, 0.0])
NO_CABLE = np.full(4, np.nan)

seeds = st.integers(0, 2**32 - 1)


def ground(rng):
    return rng.uniform(40.0, 200.0, SHAPE).astype(np.float32)


@pytest.fixture
def rng():
    return np.random.default_rng(3)


@settings(max_examples=20, deadline=None)
@given(seed=seeds, has_cable=st.booleans())
def test_a_changed_picture_is_finite_and_its_map_has_shares(seed, has_cable):
    rng = np.random.default_rng(seed)
    pose = random_pose(rng) if has_cable else NO_CABLE
    levels, cells = augmented(ground(rng).astype(np.uint8), pose, rng)
    assert levels.shape == SHAPE
    assert levels.dtype == np.float32
    assert np.isfinite(levels).all()
    assert cells.shape == (60, 80)
    assert ((cells >= 0.0) & (cells <= 1.0 + 1e-6)).all()


@settings(max_examples=10, deadline=None)
@given(seed=seeds)
def test_a_scene_without_a_cable_has_none_after_it_is_changed(seed):
    rng = np.random.default_rng(seed)
    _, cells = augmented_scene(ground(rng).astype(np.uint8), np.zeros((60, 80), np.uint8), rng)
    assert not cells.any()


def test_a_map_covers_the_cable_and_nothing_else():
    cells = true_map(UPRIGHT)
    assert cells[:, 35:45].all()
    assert not cells[:, :30].any()
    assert not cells[:, 50:].any()
    assert cells.sum() == pytest.approx(60 * 60 / 4, rel=0.01)


def test_a_picture_that_is_bent_takes_its_map_with_it(rng):
    cells = true_map(UPRIGHT)
    levels = 200.0 * np.kron(cells, np.ones((4, 4), np.float32))
    moved, shares = warp(levels, cells, rng)
    seen = moved.reshape(60, 4, 80, 4).mean((1, 3)) / 200.0
    assert np.abs(seen - shares).mean() < 0.02
    assert not np.allclose(shares, cells)
