import numpy as np
import pytest

from cable_tracker.errors import FrameError
from cable_tracker.tracking.frame_check import check_levels


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
