"""Which frames can be measured, whatever is followed in them."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError

SMALLEST_SIDE = 16
"""Smallest height and width of a frame that can be measured [px]."""


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
