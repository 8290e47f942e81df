"""Which frames can be measured, whatever is followed in them."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError

SMALLEST_SIDE = 16
"""Smallest height and width of a frame that can be measured [px]."""

LARGEST_LEVEL = 1e9
"""Largest grey level, of either sign: squares of sums of larger ones leave the range of float32, if
they are amplified."""

MAXIMUM_SIDE = 32_766
"""Largest height and width of a frame that OpenCV looks up pixels in [px]."""


def check_levels(image: Image) -> None:
    """Refuse a frame, shape (H, W) or (H, W, 3), that is too small or whose levels are none.

    Raises
    ------
    FrameError
        It is too small, of an unknown dtype, or not finite.
    """
    height, width = image.shape[:2]
    if min(height, width) < SMALLEST_SIDE:
        raise FrameError(f"{width}x{height} px is too small; at least {SMALLEST_SIDE} px each way")
    if image.dtype not in (np.uint8, np.float32):
        raise FrameError(f"levels must be uint8 or float32, not {image.dtype}")
    if image.dtype == np.float32 and not np.isfinite(image).all():
        raise FrameError("the picture has pixels that are NaN or infinite")


def check_frame(image: object) -> None:
    """Refuse what is no grey picture.

    Raises
    ------
    FrameError
        It is no array, has not two dimensions, cannot be measured (`check_levels`), is too large,
        or has levels beyond `LARGEST_LEVEL`.
    """
    if not isinstance(image, np.ndarray):
        raise FrameError(f"a picture is a NumPy array, not a {type(image).__name__}")
    if image.ndim != 2:
        raise FrameError(f"a grey picture has shape (height, width), not {image.shape}")
    check_levels(image)
    if max(image.shape) > MAXIMUM_SIDE:
        height, width = image.shape
        raise FrameError(f"{width}x{height} px is too large; at most {MAXIMUM_SIDE} px each way")
    if image.dtype == np.float32 and float(np.abs(image).max()) > LARGEST_LEVEL:
        raise FrameError(f"grey levels must lie between -{LARGEST_LEVEL:g} and {LARGEST_LEVEL:g}")
