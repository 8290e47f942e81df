from __future__ import annotations

import math
from copy import deepcopy

import cv2
import numpy as np
import pytest

from cable_tracker.metric.odometry.sea_bed_texture import (
    CALM_PICTURES,
    REMEMBERED_PICTURES,
    SeaBedTexture,
    TextureGate,
    TextureMotion,
    in_bytes,
)
from cable_tracker.sequences.encodings import decode_grey, raw_from_array

HEIGHT, WIDTH = 240, 320
STILL = np.eye(3)


def shift(x: float, y: float) -> np.ndarray:
    """The homography of a move to the right and up [px]."""
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


def moved(picture, mapping):
    """The picture after a homography of the image frame."""
    height, width = picture.shape
    to_pixel = np.array([[1.0, 0.0, (width - 1) / 2], [0.0, -1.0, (height - 1) / 2], [0, 0, 1.0]])
    pixels = to_pixel @ mapping @ np.linalg.inv(to_pixel)
    return cv2.warpPerspective(picture, pixels, (width, height), borderMode=cv2.BORDER_REFLECT)


def seen(before, after, mapping) -> TextureMotion | None:
    texture = SeaBedTexture()
    texture.compare(before, None)
    return texture.compare(after, mapping)


@pytest.fixture(scope="module")
def bottom():
    noise = np.random.default_rng(3).normal(0.0, 1.0, (HEIGHT, WIDTH))
    blurred = cv2.GaussianBlur(noise, (0, 0), 2.5)
    return np.clip(110.0 + 400.0 * blurred, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("way", [(6.0, 0.0), (0.0, -9.0), (-5.0, 7.0)])
def test_a_right_prediction_agrees(bottom, way):
    motion = seen(bottom, moved(bottom, shift(*way)), shift(*way))
    assert motion.agrees
    assert motion.error < 0.2
    assert motion.excess == 0.0
    assert motion.length == pytest.approx(math.hypot(*way), rel=0.01)


def test_a_turn_counts_as_well_as_a_shift(bottom):
    cos, sin = math.cos(0.06), math.sin(0.06)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    after = moved(bottom, turn)
    assert seen(bottom, after, turn).agrees
    assert not seen(bottom, after, turn.T).agrees
    assert not seen(bottom, after, STILL).agrees


@pytest.mark.parametrize("said", [(0.0, 0.0), (-6.0, 0.0), (0.0, 6.0), (40.0, 0.0)])
def test_a_wrong_prediction_does_not(bottom, said):
    assert not seen(bottom, moved(bottom, shift(6.0, 0.0)), shift(*said)).agrees


def test_by_how_much_it_is_off_is_measured(bottom):
    motion = seen(bottom, moved(bottom, shift(12.0, 0.0)), shift(15.0, 0.0))
    assert motion.error == pytest.approx(3.0, abs=0.2)
    # It takes most of the motion away, and is better than none.
    assert motion.agrees


def test_lengths_are_those_of_the_reference_width(bottom):
    large = cv2.resize(bottom, (640, 480), interpolation=cv2.INTER_CUBIC)
    motion = seen(large, moved(large, shift(16.0, 0.0)), shift(10.0, 0.0))
    assert motion.length == pytest.approx(5.0, abs=0.1)
    assert motion.error == pytest.approx(3.0, abs=0.3)


def test_grey_levels_may_be_float(bottom):
    after = moved(bottom, shift(6.0, 0.0))
    motion = seen(bottom.astype(np.float32), after.astype(np.float32), shift(6.0, 0.0))
    assert motion == seen(bottom, after, shift(6.0, 0.0))


def counted(picture, bits):
    """The levels of a picture whose camera counts with so many bits, sent as mono16."""
    counts = np.rint(picture / 255.0 * (2**bits - 1)).astype(np.uint16)
    return decode_grey(raw_from_array(counts, "mono16"))


@pytest.fixture(scope="module")
def dim_bottom(bottom):
    """A bottom of floats that spreads over half of the levels, with finer steps than 8 bits."""
    return 30.0 + 0.5 * cv2.GaussianBlur(bottom.astype(np.float32), (0, 0), 1.0)


@pytest.mark.parametrize("bits", [10, 11, 12, 14, 16])
def test_a_deep_camera_shows_a_bottom_as_one_of_eight_bits_does(dim_bottom, bits):
    after = moved(dim_bottom, shift(3.4, 1.0))
    motion = seen(counted(dim_bottom, bits), counted(after, bits), shift(3.4, 1.0))
    assert motion.agrees
    assert motion.error < 0.2


@pytest.mark.parametrize("bits", [10, 12])
def test_a_deep_camera_shows_that_a_prediction_is_wrong(dim_bottom, bits):
    after = moved(dim_bottom, shift(6.0, 0.0))
    motion = seen(counted(dim_bottom, bits), counted(after, bits), STILL)
    assert motion.error == pytest.approx(6.0, abs=0.2)
    assert not motion.agrees


def test_a_deep_picture_after_a_bright_flash_is_compared_with_the_next_alone(dim_bottom):
    texture = SeaBedTexture()
    dim = counted(dim_bottom, 10)
    texture.compare(np.full_like(dim, 250.0), None)
    texture.compare(dim, STILL)
    assert texture.compare(dim, STILL).agrees


def test_pictures_of_eight_bits_are_taken_as_they_are(dim_bottom):
    """A dim one has no finer steps to show."""
    faint = np.rint(dim_bottom / 16.0).astype(np.uint8)
    assert in_bytes(faint, faint)[0] is faint


def test_pixels_that_are_no_numbers_do_no_harm(bottom):
    holed = bottom.astype(np.float32)
    holed[40:60, 40:60] = np.nan
    assert seen(holed, holed, STILL).agrees


def test_a_bottom_without_texture_tells_nothing():
    grey = np.full((HEIGHT, WIDTH), 90, np.uint8)
    assert seen(grey, grey, STILL) is None


def test_borders_of_a_cable_alone_tell_nothing():
    """They look the same wherever they are moved along themselves."""
    cable = np.full((HEIGHT, WIDTH), 60, np.uint8)
    cable[:, 140:180] = 160
    assert seen(cable, cable, STILL) is None


def test_a_bottom_that_is_not_found_again_does_not_agree(bottom):
    other = np.random.default_rng(8).integers(0, 255, bottom.shape).astype(np.uint8)
    motion = seen(bottom, other, STILL)
    assert not motion.agrees


def test_what_left_the_picture_tells_nothing(bottom):
    assert seen(bottom, bottom, shift(400.0, 0.0)) is None


def test_without_a_picture_before_or_a_prediction_nothing_is_known(bottom):
    texture = SeaBedTexture()
    assert texture.compare(bottom, STILL) is None
    assert texture.compare(bottom, None) is None
    assert texture.compare(bottom, STILL) is not None


def test_pictures_of_another_size_are_not_compared(bottom):
    assert seen(bottom, bottom[:200], STILL) is None


def test_errors_and_ways_in_a_narrow_picture_are_those_of_the_reference_width(bottom):
    narrow = bottom[::2, ::2]
    motion = seen(narrow, moved(narrow, shift(4.0, 0.0)), shift(1.0, 0.0))
    assert motion.error == pytest.approx(2.0 * 3.0, abs=0.4)
    assert motion.length == pytest.approx(2.0 * 1.0, abs=0.01)


RIGHT, WRONG = TextureMotion(0.4, 8.0), TextureMotion(9.0, 8.0)


def shown(*motions):
    gate = TextureGate()
    for motion in motions:
        gate.take(motion)
    return gate


def test_at_first_nothing_is_known_of_odometry():
    assert TextureGate().verdict is None


def test_odometry_is_believed_from_the_first_picture_that_agrees():
    assert shown(RIGHT).verdict is True


def test_one_picture_that_disagrees_is_enough():
    assert shown(*[RIGHT] * 50, WRONG).verdict is False


def test_after_one_that_disagrees_it_takes_several_that_agree():
    assert shown(WRONG, *[RIGHT] * (CALM_PICTURES - 1)).verdict is False
    assert shown(WRONG, *[RIGHT] * CALM_PICTURES).verdict is True


@pytest.mark.parametrize("last", [RIGHT, WRONG])
def test_without_texture_the_last_verdict_holds_for_a_while(last):
    assert shown(last, *[None] * (REMEMBERED_PICTURES - 1)).verdict is last.agrees
    assert shown(last, *[None] * REMEMBERED_PICTURES).verdict is None


def test_a_copy_shares_the_picture_and_compares_by_itself(bottom):
    texture = SeaBedTexture()
    texture.compare(bottom, None)
    other = deepcopy(texture)
    assert other.before is texture.before
    other.compare(moved(bottom, shift(6.0, 0.0)), None)
    assert texture.compare(bottom, STILL).error < 0.2
