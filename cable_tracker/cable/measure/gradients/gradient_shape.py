"""How strong the gradients of a frame are in each direction.

Ripples, tracks and brushed sand have strong gradients across them and weak ones along. A border
that runs as they do is no news; across them, a weak one is. So a response counts in units of the
scale of the gradients in its direction.

References
----------
D. E. Tyler (1987), "A distribution-free M-estimator of multivariate scatter": the shape is that of
the directions alone. Edges, which are strong, weigh no more than grain.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.measure.gradients.scan_lines import ACROSS, ALONG
from cable_tracker.compilation import compiled_inside, compiled_loop, compiled_part

ITERATIONS = 5
"""Number of fixed-point iterations of Tyler's estimator."""

SHAPE_STEP = 8
"""Stride of the points of the scan lines that the shape is estimated from."""

LEAST_GRADIENT = 0.05
"""Weaker gradients are rounding and have no direction [robust scales]."""

LEAST_VARIANCE = 0.05
"""Smallest variance in any direction: a picture of stripes alone has none along them."""


class GradientShape(NamedTuple):
    """Covariance of the gradients in the image frame, of trace 2: 1 on average."""

    xx: float
    xy: float
    yy: float


ROUND = GradientShape(1.0, 0.0, 1.0)
"""The shape of gradients that are as strong in all directions."""


@compiled_part
def gradient_shape(rows: Image, columns: Image) -> GradientShape:
    """Return the shape of the gradients of a frame.

    Parameters
    ----------
    rows, columns : Image
        Along and across each family of scan lines [robust scales], see `ScanLines.gradients`.
    """
    most = 0
    for lines in (rows, columns):
        most += len(lines) * (lines.shape[1] // SHAPE_STEP + 1)
    strong, terms = np.empty((2, most)), np.empty((3, most))
    middle = _add_strong(rows, ALONG, ACROSS, strong, 0)
    end = _add_strong(columns, ACROSS, ALONG, strong, middle)
    xx, xy, yy = 1.0, 0.0, 1.0
    for _ in range(ITERATIONS):
        first = _weighted_moments(strong, 0, middle, terms, xx, xy, yy)
        second = _weighted_moments(strong, middle, end, terms, xx, xy, yy)
        xx, xy, yy = first[0] + second[0], first[1] + second[1], first[2] + second[2]
        trace = xx + yy
        if trace <= 0.0:
            return ROUND
        share = 2.0 * (1.0 - LEAST_VARIANCE) / trace
        xx, xy, yy = share * xx + LEAST_VARIANCE, share * xy, share * yy + LEAST_VARIANCE
    return GradientShape(xx, xy, yy)


@compiled_loop
def _add_strong(gradients: Image, x: int, y: int, strong: FloatArray, count: int) -> int:
    """Add the gradients that have a direction, of every eighth point, to the first `count` ones.

    `x` and `y` are their channels; `strong` has shape (2, K). Returns how many there are then.
    """
    for line in range(len(gradients)):
        for place in range(0, gradients.shape[1], SHAPE_STEP):
            u, v = float(gradients[line, place, x]), float(gradients[line, place, y])
            strong[0, count], strong[1, count] = u, v
            count += u * u + v * v >= LEAST_GRADIENT * LEAST_GRADIENT
    return count


@compiled_loop
def _weighted_moments(
    strong: FloatArray, start: int, stop: int, terms: FloatArray, xx: float, xy: float, yy: float
) -> tuple[float, float, float]:
    """Return the sums of g g^T / (g^T S^-1 g) over gradients g, S the shape of the last iteration.

    `terms`, shape (3, K), is room for those of each gradient: they are worked out many at a time.
    """
    x, y = strong[0, start:stop], strong[1, start:stop]
    terms_xx, terms_xy, terms_yy = terms[0], terms[1], terms[2]
    determinant = xx * yy - xy * xy
    for index in range(len(x)):
        u, v = x[index], y[index]
        square = (yy * u * u - 2.0 * xy * u * v + xx * v * v) / determinant
        terms_xx[index] = u * u / square
        terms_xy[index] = u * v / square
        terms_yy[index] = v * v / square
    sum_xx, sum_xy, sum_yy = 0.0, 0.0, 0.0
    for index in range(len(x)):
        sum_xx += terms_xx[index]
        sum_xy += terms_xy[index]
        sum_yy += terms_yy[index]
    return sum_xx, sum_xy, sum_yy


@compiled_inside
def directional_gain(shape: GradientShape, x: float, y: float) -> float:
    """Return one over the scale of the gradients in the direction of a unit vector (x, y)."""
    variance = shape.xx * x * x + 2.0 * shape.xy * x * y + shape.yy * y * y
    return 1.0 / math.sqrt(variance)
