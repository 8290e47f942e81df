"""The bins into which what is measured at a point is sorted, to be counted and to be looked up.

There are two tables of them: one of the response across the border and of its slope, and one of the
contrast between inside and outside, given the response. The borders themselves are sorted into
classes by their strength.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import Float32Array, IndexArray
from cable_tracker.compilation import compiled, compiled_inside

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
"""Smallest strength of the borders of each class; see `border_strength`. Fainter ones, which cannot
be told from the bottom, are not learnt from."""

CLASSES = len(STRENGTHS)

EDGE_SHAPE = (RESPONSE_BINS, SLOPE_BINS)
CONTRAST_SHAPE = (RESPONSE_BINS // COARSE, CONTRAST_BINS)


@dataclass(frozen=True, slots=True, eq=False)
class PointMeasures:
    """What is measured at P points of borders, all float32, of one shape.

    Attributes
    ----------
    responses : Float32Array
        Response across the border [`ScannedFrame.gradient_scale`], positive where the inside is
        brighter.
    slopes : Float32Array
        Slope of the gradient's modulus over the response [1/px at the reference width]; zero on the
        ridge of an edge. Only its size counts.
    contrasts : Float32Array
        Inside minus outside, smoothed [`ScannedFrame.contrast_scale`].
    """

    responses: Float32Array
    slopes: Float32Array
    contrasts: Float32Array

    def negative(self) -> PointMeasures:
        """Return what would be measured in a negative of the picture."""
        return PointMeasures(-self.responses, self.slopes, -self.contrasts)

    def cells(self) -> tuple[IndexArray, IndexArray]:
        """Return flat indices into the tables of edges and of contrasts, of the points' shape."""
        shape = np.shape(self.responses)
        edges, contrasts = _cells_of(
            *(np.array(each, np.float32).ravel() for each in self._columns())
        )
        return edges.reshape(shape), contrasts.reshape(shape)

    def _columns(self) -> tuple[Float32Array, Float32Array, Float32Array]:
        return self.responses, self.slopes, self.contrasts


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


@compiled
def _cells_of(
    responses: Float32Array, slopes: Float32Array, contrasts: Float32Array
) -> tuple[IndexArray, IndexArray]:
    """Return the rows (P,) of both tables; all are float32 of shape (P,)."""
    edges, contrast_cells = np.empty(len(responses), np.int64), np.empty(len(responses), np.int64)
    for point in range(len(responses)):
        edges[point] = edge_cell(responses[point], abs(slopes[point]))
        contrast_cells[point] = contrast_cell(responses[point], contrasts[point])
    return edges, contrast_cells


def border_strength(responses: Float32Array) -> float:
    """Return how strong a border is: the mean of the upper half of its responses (P,), signed."""
    highest = np.sort(responses)[::-1][: (len(responses) + 1) // 2]
    return float(highest.mean()) if len(highest) else 0.0


def strength_class(strength: float) -> int:
    """Return the class of a strength, -1 for one that is too faint for any."""
    return int(np.searchsorted(STRENGTHS, strength, side="right")) - 1
