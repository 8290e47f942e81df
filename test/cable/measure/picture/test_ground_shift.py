"""The ground beside a strip: how far it has moved is told, or nothing is."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.picture.ground_shift import (
    SIDE,
    ground_shifts,
    patches_beside,
)

SIZE = (320, 240)
UPRIGHT = np.array([10.0, 0.0, 30.0, 0.0])


def ground(right=0.0, up=0.0, size=SIZE, seed=0) -> np.ndarray:
    """Return a textured ground that has moved so far [px], float32."""
    width, height = size
    texture = np.random.default_rng(seed).normal(110.0, 25.0, (height + 80, width + 80))
    texture = cv2.GaussianBlur(texture.astype(np.float32), (0, 0), 2.0)
    moved = cv2.warpAffine(
        texture, np.float32([[1, 0, right], [0, 1, -up]]), texture.shape[::-1],
        flags=cv2.INTER_CUBIC,
    )  # fmt: skip
    return moved[40:-40, 40:-40].copy()


def shifts_of(before, after, pose=UPRIGHT, scale=1.0):
    return ground_shifts(patches_beside(pose, before, scale), after)


@given(st.floats(-12.0, 12.0), st.floats(-12.0, 12.0))
def test_the_shift_of_both_sides_is_told(right, up):
    told = shifts_of(ground(), ground(right, up))
    np.testing.assert_allclose(told, [[right, up]] * 2, atol=1.5)


def test_patches_lie_to_either_side_and_clear_of_the_strip():
    picture = np.zeros((240, 320), np.float32)
    # The strip alone is bright: no patch may see it.
    picture[:, 155:185] = 200.0
    patches = patches_beside(UPRIGHT, picture, 1.0)
    (left, _), (right, _) = patches.corners
    assert left + SIDE <= 155
    assert right >= 185
    assert all(np.ptp(patch) == 0.0 for patch in patches.patches)


@pytest.mark.parametrize(
    "pose",
    [
        [0.0, 0.0, 280.0, 0.0],  # as wide as the picture
        [400.0, 0.0, 20.0, 0.0],  # out of view
    ],
)
def test_without_room_on_either_side_there_are_no_patches(pose):
    assert patches_beside(np.array(pose), ground(), 1.0) is None


def test_at_the_edge_of_the_picture_the_ground_of_one_side_is_told():
    told = shifts_of(ground(), ground(5.0, -3.0), pose=np.array([150.0, 0.0, 20.0, 0.0]))
    np.testing.assert_allclose(told, [[5.0, -3.0]], atol=1.5)


def test_a_picture_smaller_than_a_patch_has_no_room():
    assert patches_beside(np.array([0.0, 0.0, 4.0, 0.0]), ground(size=(60, 40)), 1.0) is None


def test_nothing_is_told_of_a_picture_of_another_size():
    assert shifts_of(ground(), ground(size=(200, 150))) is None


def test_nothing_is_told_of_other_ground():
    assert shifts_of(ground(), ground(seed=1)) is None


def test_nothing_is_told_of_ground_without_texture():
    flat = np.full((240, 320), 90.0, np.float32)
    assert shifts_of(flat, flat) is None


def test_nothing_is_told_of_ground_that_has_left_most_of_its_patch():
    assert shifts_of(ground(), ground(right=30.0)) is None


def test_a_picture_of_twice_the_width_has_patches_twice_as_large():
    patches = patches_beside(2.0 * UPRIGHT, ground(size=(640, 480)), 2.0)
    assert [patch.shape for patch in patches.patches] == [(2 * SIDE, 2 * SIDE)] * 2
