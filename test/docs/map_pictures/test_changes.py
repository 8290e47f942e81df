"""What is done to pictures to train on, and to the maps that say where the cable is in them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from map_pictures.beside_cables import scarred, seamed, trenched, visited
from map_pictures.camera import bent
from map_pictures.changes import augmented, augmented_scene
from map_pictures.grounds import GROUNDS
from map_pictures.light import barred, dappled, lit, pooled, snowed, veiled
from map_pictures.skins import shown_share
from map_pictures.surface import any_pose, surface, true_map

SHAPE = (240, 320)
UPRIGHT = np.array([0.0, 0.0, 60.0, 0.0])
NO_CABLE = np.full(4, np.nan)
LIGHTS = (barred, dappled, lit, pooled, snowed, veiled, visited)

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
    pose = any_pose(rng) if has_cable else NO_CABLE
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


@pytest.mark.parametrize("change", LIGHTS)
def test_light_and_what_lies_in_front_change_some_pictures(change):
    changed = []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        levels = ground(rng)
        before = levels.copy()
        after = change(levels, rng)
        assert np.array_equal(levels, before)
        assert np.isfinite(after).all()
        changed.append(not np.allclose(after, before))
    assert any(changed)


def test_a_map_covers_the_cable_and_nothing_else():
    cells = true_map(UPRIGHT)
    assert cells[:, 35:45].all()
    assert not cells[:, :30].any()
    assert not cells[:, 50:].any()
    assert cells.sum() == pytest.approx(60 * 60 / 4, rel=0.01)


def test_a_picture_that_is_bent_takes_its_map_with_it(rng):
    cells = true_map(UPRIGHT)
    levels = 200.0 * np.kron(cells, np.ones((4, 4), np.float32))
    moved, shares = bent(levels, cells, rng)
    seen = moved.reshape(60, 4, 80, 4).mean((1, 3)) / 200.0
    assert np.abs(seen - shares).mean() < 0.02
    assert not np.allclose(shares, cells)


@settings(max_examples=20, deadline=None)
@given(seed=seeds, width=st.floats(8.0, 100.0))
def test_a_trench_leaves_the_cable_as_it_is(seed, width):
    rng = np.random.default_rng(seed)
    levels = ground(rng)
    at = surface(np.array([0.0, 0.3, width, 0.0]), SHAPE)
    ditch = trenched(levels, at, rng)
    inside = at.outside < -3.0
    assert ditch[inside] == pytest.approx(levels[inside], rel=0.05)
    assert not np.allclose(ditch, levels)


@settings(max_examples=20, deadline=None)
@given(seed=seeds)
def test_scars_leave_the_cable_as_it_is(seed):
    rng = np.random.default_rng(seed)
    levels = ground(rng)
    scars = scarred(levels, true_map(UPRIGHT), rng)
    assert scars[:, 140:180] == pytest.approx(levels[:, 140:180], rel=1e-5)
    assert not np.allclose(scars, levels)


def test_the_shadow_of_a_frame_darkens_and_lets_the_ground_show_through(rng):
    levels = ground(rng)
    light = barred(levels, rng) / levels
    assert light.max() <= 1.0
    assert light.min() < 0.86
    # Along a band the ground is darkened by one factor, however it differs from place to place.
    deepest = light[np.isclose(light, light.min(), atol=1e-4)]
    assert len(deepest) > 100


def test_plain_ground_takes_no_shadow_of_a_frame(rng):
    plain = np.full(SHAPE, 100.0, np.float32)
    assert np.array_equal(barred(plain, rng), plain)


@settings(max_examples=20, deadline=None)
@given(seed=seeds, width=st.floats(20.0, 100.0))
def test_a_quarter_of_a_buried_cable_or_more_is_shown(seed, width):
    rng = np.random.default_rng(seed)
    at = surface(np.array([0.0, 0.3, width, 0.0]), SHAPE)
    shares = shown_share(at, rng)
    assert shares.shape == SHAPE
    assert ((shares >= 0.0) & (shares <= 1.0 + 1e-6)).all()
    assert shares[at.outside < 0.0].mean() > 0.2


def test_seams_are_dark_and_lie_along_the_flanks(rng):
    levels = np.full(SHAPE, 100.0, np.float32)
    at = surface(UPRIGHT, SHAPE)
    dark = seamed(levels, at, 1.0, rng) < 95.0
    assert dark[:, : SHAPE[1] // 2].any()
    assert dark[:, SHAPE[1] // 2 :].any()
    assert np.abs(at.outside[dark]).max() < 15.0


@pytest.mark.parametrize("make", GROUNDS)
def test_grounds_differ_from_place_to_place(make):
    for seed in range(3):
        field = make(np.random.default_rng(seed))
        assert np.isfinite(field).all()
        assert field.std() > 0.0


@settings(max_examples=30, deadline=None)
@given(angle=st.floats(-1.5, 1.5), width=st.floats(4.0, 150.0), skew=st.floats(-0.2, 0.2))
def test_the_foot_point_lies_midway_between_the_borders(angle, width, skew):
    at = surface(np.array([0.0, angle, width, skew]), SHAPE)
    middle = at.outside[119:121, 159:161].mean()
    assert middle == pytest.approx(-0.5 * width * math.cos(skew), abs=1.0)
