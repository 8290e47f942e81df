import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_images import plain_image

from cable_tracker.cable.hypotheses.vehicle_fixture import (
    FEWEST_LOOKS,
    LEAST_ACROSS,
    LOOK_INTERVAL,
    SIDE,
    STILL,
    UNTESTED,
    fixture_test_after,
    ground_shifts,
    patches_beside,
)

SIZE = (320, 240)
TRAVEL = 6.0
FRAME = 0.08
UPRIGHT = np.array([10.0, 0.0, 30.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def ground(right=0.0, up=0.0, size=SIZE, seed=0) -> np.ndarray:
    """Return a textured ground that has moved so far [px], float32."""
    width, height = size
    texture = np.random.default_rng(seed).normal(110.0, 25.0, (height + 400, width + 400))
    texture = cv2.GaussianBlur(texture.astype(np.float32), (0, 0), 2.0)
    moved = cv2.warpAffine(
        texture, np.float32([[1, 0, right], [0, 1, -up]]), texture.shape[::-1],
        flags=cv2.INTER_CUBIC,
    )  # fmt: skip
    return moved[200:-200, 200:-200].copy()


def shifts_of(before, after, pose=UPRIGHT, scale=1.0):
    return ground_shifts(patches_beside(pose, before, scale), after)


@given(st.floats(-12.0, 12.0), st.floats(-12.0, 12.0))
def test_the_shift_of_both_sides_is_measured(right, up):
    shifts = shifts_of(ground(), ground(right, up))
    np.testing.assert_allclose(shifts, [[right, up]] * 2, atol=1.5)


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


def test_at_the_edge_of_the_picture_the_shift_of_one_side_is_measured():
    shifts = shifts_of(ground(), ground(5.0, -3.0), pose=np.array([150.0, 0.0, 20.0, 0.0]))
    np.testing.assert_allclose(shifts, [[5.0, -3.0]], atol=1.5)


def test_a_picture_smaller_than_a_patch_has_no_room():
    assert patches_beside(np.array([0.0, 0.0, 4.0, 0.0]), ground(size=(60, 40)), 1.0) is None


def test_a_picture_of_another_size_gives_no_shift():
    assert shifts_of(ground(), ground(size=(200, 150))) is None


def test_unrelated_ground_gives_no_shift():
    assert shifts_of(ground(), ground(seed=1)) is None


def test_ground_without_texture_gives_no_shift():
    flat = np.full((240, 320), 90.0, np.float32)
    assert shifts_of(flat, flat) is None


def test_ground_that_has_left_most_of_its_patch_gives_no_shift():
    assert shifts_of(ground(), ground(right=30.0)) is None


def test_a_picture_of_twice_the_width_has_patches_twice_as_large():
    patches = patches_beside(2.0 * UPRIGHT, ground(size=(640, 480)), 2.0)
    assert [patch.shape for patch in patches.patches] == [(2 * SIDE, 2 * SIDE)] * 2


def aside(distance) -> np.ndarray:
    """Return the strip moved to the right [px]."""
    state = UPRIGHT.copy()
    state[0] += distance
    return state


def dive(velocity, strip=lambda frame: UPRIGHT, frames=24, before=UNTESTED, goes_on=True):
    """Return the test after frames whose ground moves by (right, up) px each."""
    test = before
    for frame in range(frames):
        image = plain_image(ground(velocity[0] * frame, velocity[1] * frame))
        test = fixture_test_after(
            test, strip(frame), image, FRAME, TRAVEL, goes_on=goes_on and frame > 0
        )
    return test


def test_a_strip_that_stands_still_while_the_ground_moves_across_it_is_a_fixture():
    np.testing.assert_array_equal(dive((2.0, 3.0)).fixture, UPRIGHT)


def test_a_strip_that_moves_with_the_ground_is_no_fixture():
    assert dive((2.0, 1.0), lambda frame: aside(2.0 * frame)).fixture is None


def test_ground_that_moves_along_the_strip_proves_no_fixture():
    assert dive((0.3, 4.0)).fixture is None


def test_a_strip_that_goes_to_and_fro_while_the_ground_moves_one_way_is_no_fixture():
    """In perspective the ground may seem to move less than the strip when both go one way."""
    test = dive((2.0, 0.0), lambda frame: aside(8.0 * (frame // 4 % 2)))
    assert abs(test.strip) < STILL * abs(test.ground)
    assert test.fixture is None


# At the left edge, so that there is room on its right side alone; its borders meet far up.
SKEWED = np.array([-110.0, 0.0, 100.0, 0.25, 0.0, 0.0, 0.0, 0.0])


def test_ground_that_moves_along_a_strip_in_perspective_proves_no_fixture():
    """It moves towards the point at which the borders meet, farther aside the more so."""
    meeting = np.array([-110.0, 50.0 / np.tan(0.25)])
    patch = np.array([-110.0 + 50.0 + 2.0 + 32.0, 0.0])
    velocity = 3.0 * (meeting - patch) / np.linalg.norm(meeting - patch)
    test = dive(velocity, lambda frame: SKEWED)
    assert abs(velocity[0]) > LEAST_ACROSS * 3.0
    assert test.looks >= FEWEST_LOOKS
    assert test.ground_path > TRAVEL
    assert test.fixture is None


def test_a_skewed_strip_that_stands_still_while_the_ground_moves_across_it_is_a_fixture():
    np.testing.assert_array_equal(dive((2.0, 0.0), lambda frame: SKEWED).fixture, SKEWED)


def test_ground_that_stands_still_proves_no_fixture():
    assert dive((0.0, 0.0)).fixture is None


def parted_ground(frame) -> np.ndarray:
    """Return a ground that goes to the left on one side, and to the right on the other."""
    picture = ground(-2.0 * frame)
    picture[:, 170:] = ground(2.0 * frame)[:, 170:]
    return picture


def test_ground_that_parts_to_both_sides_proves_no_fixture():
    test = UNTESTED
    for frame in range(24):
        image = plain_image(parted_ground(frame))
        test = fixture_test_after(test, UPRIGHT, image, FRAME, TRAVEL, goes_on=frame > 0)
    assert test.ground_path > TRAVEL
    assert test.looks == 0
    assert test.fixture is None


def test_a_strip_that_goes_one_way_while_the_ground_parts_and_back_with_it_is_no_fixture():
    test = UNTESTED
    for frame in range(24):
        back = max(frame - 11, 0)
        picture = parted_ground(frame) if frame < 12 else ground(-2.0 * back)
        strip = aside(min(frame, 11) - 2.0 * back)
        image = plain_image(picture)
        test = fixture_test_after(test, strip, image, FRAME, TRAVEL, goes_on=frame > 0)
        assert test.fixture is None
    assert test.looks >= FEWEST_LOOKS


def test_too_few_looks_prove_no_fixture():
    looks = 1 + round(FEWEST_LOOKS * LOOK_INTERVAL / FRAME)
    assert dive((6.0, 0.0), frames=looks - 1).fixture is None


def test_looks_at_a_hypothesis_that_does_not_go_on_are_not_counted_up():
    test = dive((2.0, 0.0), goes_on=False)
    assert test.looks == 0
    assert test.fixture is None


def test_a_fixture_is_remembered_while_another_hypothesis_leads():
    found = dive((2.0, 0.0))
    image = plain_image(ground())
    other = fixture_test_after(found, aside(-80.0), image, FRAME, TRAVEL, goes_on=False)
    assert other.looks == 0
    np.testing.assert_array_equal(other.fixture, UPRIGHT)


def test_a_fixture_that_moves_with_the_ground_is_forgotten():
    found = dive((2.0, 0.0))
    assert dive((2.0, 0.0), lambda frame: aside(2.0 * frame), before=found).fixture is None


def test_a_strip_at_the_edge_of_the_picture_is_held_against_the_ground_of_one_side():
    edge = aside(135.0)
    np.testing.assert_array_equal(dive((-2.0, 1.0), lambda frame: edge).fixture, edge)
    assert dive((-2.0, 1.0), lambda frame: aside(135.0 - 2.0 * frame)).fixture is None


def test_a_strip_as_wide_as_the_picture_is_not_tested():
    wide = np.array([10.0, 0.0, 280.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    test = dive((3.0, 0.0), lambda frame: wide)
    assert test.patches is None
    assert test.looks == 0


@pytest.mark.parametrize("travel", [3.0, 30.0])
def test_the_longer_the_travel_the_later_a_fixture_is_found(travel):
    test, found = UNTESTED, None
    for frame in range(40):
        image = plain_image(ground(1.5 * frame))
        test = fixture_test_after(test, UPRIGHT, image, FRAME, travel, goes_on=frame > 0)
        if test.fixture is not None and found is None:
            found = frame
    assert (found is None) == (travel == 30.0)
