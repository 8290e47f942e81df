"""The bins into which what is measured at a point is sorted, to be counted and to be looked up.

There are two tables of them: one of the response across the border and of its slope, and one of the
contrast between inside and outside, given the response. The borders themselves are sorted into
classes by their strength.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.compilation import compiled_inside

RESPONSE_LIMIT = 12.0
"""Responses beyond this many robust scales are taken for this one."""

RESPONSE_BINS = 96

SLOPE_LIMIT = 0.75
"""Slopes beyond this [1/px] are taken for this one: the edge is more than 2 px away."""

SLOPE_BINS = 15

CONTRAST_LIMIT = 12.0
"""Contrasts beyond this many scales of the contrast are taken for this one."""

CONTRAST_BINS = 25
"""An odd number: a contrast of nothing at all, which is frequent, lies in the middle of a bin."""

COARSE = 4
"""Bins of the response that are merged into one in the table of contrasts."""

RESPONSE_MIDDLE, CONTRAST_MIDDLE = np.float32(RESPONSE_LIMIT), np.float32(CONTRAST_LIMIT)
RESPONSE_FACTOR = np.float32(RESPONSE_BINS / (2 * RESPONSE_LIMIT))
SLOPE_FACTOR = np.float32(SLOPE_BINS / SLOPE_LIMIT)
CONTRAST_FACTOR = np.float32(CONTRAST_BINS / (2 * CONTRAST_LIMIT))
"""What numbers are shifted by, and bins per unit, in single precision as in the kernels."""

STRENGTHS = (1.2, 1.8, 2.7, 4.0)
"""Smallest strength of the borders of each class; see `border_strength` of cable/learning. Fainter
ones, which cannot be told from the bottom, are not learnt from."""

CLASSES = len(STRENGTHS)

EDGE_SHAPE = (RESPONSE_BINS, SLOPE_BINS)
CONTRAST_SHAPE = (RESPONSE_BINS // COARSE, CONTRAST_BINS)


@compiled_inside
def _bin(value: np.float32, shift: np.float32, factor: np.float32, count: int) -> np.int32:
    scaled = (value + shift) * factor
    return np.int32(min(max(scaled, np.float32(0.0)), np.float32(count - 1)))


@compiled_inside
def edge_cell(response: np.float32, slope: np.float32) -> np.uint32:
    """Return the row of the table of edges for a response and the size of a slope."""
    row = _bin(response, RESPONSE_MIDDLE, RESPONSE_FACTOR, RESPONSE_BINS)
    return np.uint32(row * SLOPE_BINS + _bin(slope, np.float32(0.0), SLOPE_FACTOR, SLOPE_BINS))


@compiled_inside
def contrast_cell(response: np.float32, contrast: np.float32) -> np.uint32:
    """Return the row of the table of contrasts for a response and a contrast."""
    row = _bin(response, RESPONSE_MIDDLE, RESPONSE_FACTOR, RESPONSE_BINS) // COARSE
    cell = _bin(contrast, CONTRAST_MIDDLE, CONTRAST_FACTOR, CONTRAST_BINS)
    return np.uint32(row * CONTRAST_BINS + cell)


@compiled_inside
def point_cell(response: np.float32, slope: np.float32, contrast: np.float32) -> np.uint32:
    """Return the row of the table of all three for a response, the size of a slope, a contrast."""
    cell = _bin(contrast, CONTRAST_MIDDLE, CONTRAST_FACTOR, CONTRAST_BINS)
    return np.uint32(edge_cell(response, slope) * CONTRAST_BINS + cell)
