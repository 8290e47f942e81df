import numpy as np
import pytest

from cable_tracker.errors import FrameError
from cable_tracker.tracking.frame_check import check_frame, check_levels


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (np.zeros((15, 320), np.uint8), "320x15 px is too small"),
        (np.zeros((320, 15, 3), np.uint8), "15x320 px is too small"),
        (np.zeros((20, 20, 3), np.float64), "float64"),
        (np.full((20, 20, 3), np.nan, np.float32), "NaN"),
        (np.full((20, 20), np.inf, np.float32), "infinite"),
    ],
)
def test_what_cannot_be_measured_is_refused(image, words):
    with pytest.raises(FrameError, match=words):
        check_levels(image)


@pytest.mark.parametrize("shape", [(16, 16), (16, 16, 3)])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_small_pictures_are_accepted(shape, dtype):
    check_levels(np.zeros(shape, dtype))


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (np.zeros((240, 320, 3), np.uint8), r"not \(240, 320, 3\)"),
        (np.zeros(320, np.uint8), r"not \(320,\)"),
        (np.zeros((0, 0), np.uint8), "0x0 px is too small"),
        (np.zeros((15, 320), np.uint8), "320x15 px is too small"),
        (np.zeros((40000, 20), np.uint8), "20x40000 px is too large"),
        (np.zeros((20, 20), np.float64), "float64"),
        (np.zeros((20, 20), np.uint16), "uint16"),
        ([[0, 1], [2, 3]], "a NumPy array, not a list"),
        (np.full((20, 20), np.nan, np.float32), "NaN"),
        (np.full((20, 20), np.inf, np.float32), "infinite"),
        (np.full((20, 20), -3e38, np.float32), "between -1e\\+09 and 1e\\+09"),
    ],
)
def test_what_is_no_grey_picture_is_refused_in_one_line(image, words):
    with pytest.raises(FrameError, match=words) as caught:
        check_frame(image)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_small_grey_pictures_are_accepted(dtype):
    check_frame(np.zeros((16, 16), dtype))
