import cv2
import numpy as np
import pytest

from cable_tracker.target.measure.working_frame import make_working_frame

RED = (30, 30, 200)


def luma_of(picture):
    return cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)


def with_red(columns, shape=(48, 64)):
    picture = np.full((*shape, 3), 110, np.uint8)
    picture[:, :columns] = RED
    return picture


@pytest.mark.parametrize(
    ("columns", "is_coloured", "has_chroma"), [(0, False, False), (20, True, True)]
)
def test_a_frame_is_coloured_by_its_pixels_and_not_by_its_channels(
    columns, is_coloured, has_chroma
):
    frame = make_working_frame(with_red(columns), 64)
    assert (frame.is_coloured, frame.has_chroma) == (is_coloured, has_chroma)


def test_a_few_pixels_make_no_coloured_frame_but_are_seen():
    picture = with_red(0, (240, 320))
    picture[9:12, 9:12] = RED
    frame = make_working_frame(picture, 320)
    assert not frame.is_coloured
    assert frame.has_chroma


def test_a_grey_frame_measured_in_colour_has_none():
    frame = make_working_frame(with_red(0)[..., 0], 64).measured_in(colour=True)
    assert frame.is_coloured
    assert (frame.channels[..., 1:] == 128).all()


def test_a_coloured_frame_measured_in_grey_is_the_same_as_the_grey_frame():
    coloured = make_working_frame(with_red(20), 64).measured_in(colour=False)
    luma = round(0.299 * RED[2] + 0.587 * RED[1] + 0.114 * RED[0])
    grey = np.where(np.arange(64) < 20, luma, 110).astype(np.uint8) * np.ones((48, 1), np.uint8)
    np.testing.assert_array_equal(coloured.channels, make_working_frame(grey, 64).channels)


@pytest.mark.parametrize("width", [32, 64])
@pytest.mark.parametrize("columns", [0, 20], ids=["without colour", "coloured"])
def test_a_picture_in_grey_is_as_sharp_whatever_its_colours(columns, width):
    picture = with_red(columns)
    picture[:, 40:] = 220
    colours, grey = (make_working_frame(each, width).grey for each in (picture, luma_of(picture)))
    assert np.abs(colours.astype(int) - grey).max() <= 1
