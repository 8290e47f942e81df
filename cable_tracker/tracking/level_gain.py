"""The gain of deep pictures that use few of their levels.

What is measured has floors in grey levels of 8 bits: below them a difference is noise of the
quantisation. A picture of 16 bits or floats has finer steps. A camera of 10 bits whose counts are
sent as mono16 shows the brightest white as 4 of 255 levels, and all of a dim dive within one.
"""

from __future__ import annotations

from math import floor, log2

import numpy as np

from cable_tracker.arrays import Image

NARROW, USUAL, WIDE = 8.0, 32.0, 128.0
"""Spread of the grey levels of a picture, times the gain: below the first the gain is raised, above
the last it is lowered, so that it comes to about the second. Between them it stays as it is, for
what compares one frame with the next compares levels."""

LARGEST_GAIN = 256.0
"""Beyond it, one step of 16 bits would be a whole grey level."""

HALF_OF_WHITE = 127.5
"""Half of the brightest level."""

SPREAD = (2.0, 98.0)
"""Percentiles whose difference is the spread: captions have fewer pixels."""

STEP = 4
"""Every so many rows and columns are looked at."""


def level_gain(before: float, picture: Image) -> float:
    """Return what the grey levels of a picture are multiplied by: 1, or a greater power of two.

    A power of two leaves every difference of levels as exact as it was.

    Parameters
    ----------
    before : float
        The gain of the picture before; 1 for the first.
    picture : Image
        Grey levels, uint8 or float32, shape (H, W). Those of uint8 have no finer steps: their gain
        is 1.
    """
    if picture.dtype == np.uint8:
        return 1.0
    low, high = level_range(picture)
    spread = high - low
    if spread == 0.0 or NARROW <= before * spread <= WIDE:
        return before
    wanted = 2.0 ** round(log2(USUAL / spread))
    return min(max(wanted, 1.0), LARGEST_GAIN)


def byte_gain(picture: Image) -> float:
    """Return a gain as `level_gain` does for a first picture, but for one to be rounded to 8 bits.

    It is no greater than leaves all but the brightest few levels below half of white: the pictures
    that follow may be brighter, and what is brighter than white is cut off.

    Parameters
    ----------
    picture : Image
        Levels 0..255, uint8 or float32, shape (H, W) or (H, W, 3).
    """
    gain = level_gain(1.0, picture)
    return min(gain, gain_below_white(level_range(picture)[1])) if gain > 1.0 else gain


def gain_below_white(level: float) -> float:
    """Return the greatest gain that leaves a level below half of white: 1, or a power of two."""
    if level <= HALF_OF_WHITE / LARGEST_GAIN:
        return LARGEST_GAIN
    return max(2.0 ** floor(log2(HALF_OF_WHITE / level)), 1.0)


def level_range(picture: Image) -> tuple[float, float]:
    """Return the levels between which those of a picture spread, all but the outermost few."""
    low, high = np.percentile(picture[::STEP, ::STEP], SPREAD)
    return float(low), float(high)


def amplified(picture: Image, gain: float) -> Image:
    """Return a picture, grey or in colour, with its levels times a gain; itself where it is 1."""
    return picture if gain == 1.0 else np.multiply(picture, np.float32(gain))
