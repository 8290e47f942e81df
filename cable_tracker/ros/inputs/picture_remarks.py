"""Remarks about odd pictures, in words for the diagnostics."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.tracking.level_gain import amplified, level_gain

BLACK, WHITE = 2.0, 253.0
"""Grey levels up to and from which nothing can be told apart."""

MOST = 0.9
"""Share of pixels that makes a picture black or saturated."""


def remark_on(picture: Image | None) -> str:
    """Say what is odd about a picture; empty where nothing is.

    Such pictures are not refused: the filters find nothing in them, and say so.

    Parameters
    ----------
    picture : Image or None
        Grey levels 0..255, shape (H, W), or colours (H, W, 3), whose channels are looked at
        together; None before the first.
    """
    if picture is None:
        return ""
    low, high = float(picture.min()), float(picture.max())
    if low == high:
        return f"all pixels are the same ({low:g} of 255)"
    # Of more than eight bits, a scene can be told apart within a single grey level.
    dark = float(np.mean(amplified(picture, level_gain(1.0, picture)) <= BLACK))
    bright = float(np.mean(picture >= WHITE))
    if dark >= MOST:
        return f"black: {100 * dark:.0f} % of the pixels"
    if bright >= MOST:
        return f"saturated: {100 * bright:.0f} % of the pixels are white"
    return ""
