"""The picture that stands for a frame that cannot be shown."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import Image

STAND_IN_SIZE = (320, 240)
"""Width and height of the picture [px]."""

DARK = 40


def stand_in() -> Image:
    """Return an even dark picture, uint8, grey, shape (240, 320)."""
    return np.full((STAND_IN_SIZE[1], STAND_IN_SIZE[0]), DARK, np.uint8)
