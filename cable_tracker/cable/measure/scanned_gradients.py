"""Gradients of a frame along its scan lines, worked out once and read at many points.

Borders are not measured everywhere, but where they cross rows of the picture, `sample_spacing`
apart, or such columns if they run flat: only there are the gradients worked out. Along such a line,
everything that is asked of a border (is there an edge, is it here, what lies beside it) is found at
other places of the same line.

Two things are known of an edge: the gradient of the smoothed picture, and the slope of its modulus.
The first, projected on the normal of a line, is the response of a derivative-of-Gaussian filter
across that line. The second tells how far away the edge is: it is zero on the edge itself.

Ripples, tracks and brushed sand have strong gradients across them and weak ones along. A border
that runs as they do is no news; across them, a weak one is. So a response counts in units of the
scale of the gradients in its direction, see `GradientShape`.

References
----------
D. E. Tyler (1987), "A distribution-free M-estimator of multivariate scatter": the shape is that of
the directions alone. Edges, which are strong, weigh no more than grain.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.measure.scan_filters import (
    ScanKernels,
    antisymmetric_along,
    fold_across,
    mirror_ends,
    sum_across,
    symmetric_along,
)
from cable_tracker.compilation import (
    compiled,
    compiled_fast_loop,
    compiled_fast_part,
    compiled_inside,
    compiled_loop,
    compiled_part,
)
from cable_tracker.tracking.image_frame import to_image
from cable_tracker.tracking.robust import robust_scale

NOISE_FLOOR = 0.1
"""Smallest robust scale of a frame [grey levels per px]: below it lies the rounding of pixels."""

SMALLEST_CONTRAST = 0.3
"""Smallest scale of the contrast [grey levels]."""

SCALE_STEP = 8
"""Robust scales are taken over every eighth point of the scan lines: they say the same as all."""

ALONG, ACROSS, SLOPE = range(3)
"""Channels: the last axis of `ScanLines.gradients`."""

ITERATIONS = 5
"""Number of fixed-point iterations of Tyler's estimator."""

SHAPE_STEP = 8
"""Stride of the points of the scan lines that the shape is estimated from."""

LEAST_GRADIENT = 0.05
"""Weaker gradients are rounding and have no direction [robust scales]."""

LEAST_VARIANCE = 0.05
"""Smallest variance in any direction: a picture of stripes alone has none along them."""


class ScanInputs(NamedTuple):
    """What is measured of a frame along its rows and columns.

    Attributes
    ----------
    rows, columns : ScanLines
        Scan lines along which steep and flat borders are measured.
    gradient_scale : float
        Robust standard deviation of the gradient over the frame [grey levels per px]. A cable
        covers too little of it to move the median.
    reduction : float
        Working pixels per frame pixel.
    scale : float
        Working pixels per pixel of an image of the reference width.
    points_across : float
        Number of points of a border that runs through the picture along its shorter side.
    shape : GradientShape
        Covariance of the gradients, by which responses are divided; the identity where only
        gradients are asked for.
    """

    rows: ScanLines
    columns: ScanLines
    gradient_scale: float
    reduction: float
    scale: float
    points_across: float
    shape: GradientShape


def line_indices(length: int, spacing: int) -> IndexArray:
    """Return which rows of a picture of this height [px] are scanned: centred, `spacing` apart."""
    count = (length - 1) // spacing + 1
    first = (length - 1 - (count - 1) * spacing) // 2
    return np.arange(count, dtype=np.int64) * spacing + first


@cache
def scan_places(
    size: tuple[int, int], spacing: int
) -> tuple[IndexArray, IndexArray, tuple[FloatArray, FloatArray]]:
    """Return which rows and columns of a picture of a size are scanned, and v of each of them.

    Columns are scanned upwards: v of a column is its x, see `ScanLines`.
    """
    width, height = size
    rows, columns = line_indices(height, spacing), line_indices(width, spacing)
    x, y = to_image(columns, rows, size)
    return rows, columns, (y, x)


def scan_frame(
    picture: Image, spacing: int, kernels: ScanKernels, reduction: float, scale: float
) -> ScanInputs:
    """Work out the gradients along the scan lines of a picture.

    Parameters
    ----------
    picture : Image
        Grey levels, uint8 or float32, shape (h, w).
    spacing : int
        Distance between the lines [px].
    kernels : ScanKernels
        The filters. Their `contrast_lag` must be shorter than the longer side of the picture.
    reduction, scale : float
        See `ScanInputs`.
    """
    height, width = picture.shape
    rows, columns, places = scan_places((width, height), spacing)
    # One kind of array: for bytes, and for frames that cannot be written to, Numba would compile
    # anew.
    pixels = np.require(picture, np.float32, ("C", "W", "A"))
    # Columns are scanned upwards: the rows of this one are the columns of that, from below.
    turned = np.asarray(cv2.rotate(pixels, cv2.ROTATE_90_CLOCKWISE))
    points_across = min(height, width) / spacing
    return _scan_both(
        pixels, turned, rows, columns, places, kernels, reduction, scale, points_across
    )


@compiled
def _scan_both(
    pixels: Image,
    turned: Image,
    rows: IndexArray,
    columns: IndexArray,
    places: tuple[FloatArray, FloatArray],
    kernels: ScanKernels,
    reduction: float,
    scale: float,
    points_across: float,
) -> ScanInputs:
    """Work out the gradients of a picture along its rows, and of the turned one along its columns.

    `places` are those of the rows and of the columns; `reduction`, `scale` and `points_across` are
    those of `ScanInputs`.
    """
    # Rows run down where v runs up.
    gradients, smooth = _scan(pixels, rows, np.float32(-1.0), kernels)
    turned_gradients, turned_smooth = _scan(turned, columns, np.float32(1.0), kernels)
    gradient_scale = max(_gradient_scale(gradients, turned_gradients), NOISE_FLOOR)
    for values in (gradients, turned_gradients):
        _multiply(values.reshape(-1), np.float32(1.0 / gradient_scale))
    shape = ROUND
    if len(kernels.region):
        contrast_scale = max(
            _contrast_scale(smooth, turned_smooth, kernels.contrast_lag), SMALLEST_CONTRAST
        )
        for values in (smooth, turned_smooth):
            _multiply(values.reshape(-1), np.float32(1.0 / contrast_scale))
        shape = gradient_shape(gradients, turned_gradients)
    return ScanInputs(
        ScanLines(gradients, smooth, places[0]),
        ScanLines(turned_gradients, turned_smooth, places[1]),
        gradient_scale,
        reduction,
        scale,
        points_across,
        shape,
    )


@compiled_part
def _gradient_scale(gradients: Image, turned_gradients: Image) -> float:
    """Return the robust scale of the gradients of both families [grey levels per px]."""
    most = gradients.size + turned_gradients.size
    sizes, count = np.empty(most, np.float32), 0
    for family in (gradients, turned_gradients):
        for line in range(len(family)):
            for x in range(0, family.shape[1], SCALE_STEP):
                sizes[count] = abs(family[line, x, ALONG])
                sizes[count + 1] = abs(family[line, x, ACROSS])
                count += 2
    return robust_scale(sizes[:count])


@compiled_part
def _contrast_scale(smooth: Image, turned_smooth: Image, lag: int) -> float:
    """Return the robust scale of differences along the lines, over a lag [grey levels].

    That is what slow changes of the light alone make of the inside and the outside of a border.
    """
    sizes, count = np.empty(smooth.size + turned_smooth.size, np.float32), 0
    for family in (smooth, turned_smooth):
        for line in range(len(family)):
            for x in range(0, family.shape[1] - lag, SCALE_STEP):
                sizes[count] = abs(family[line, x + lag] - family[line, x])
                count += 1
    return robust_scale(sizes[:count])


@compiled_fast_loop
def _multiply(values: Image, factor: np.float32) -> None:
    for index in range(len(values)):
        values[index] *= factor


@compiled_fast_part
def _scan(
    pixels: Image, lines: IndexArray, sign: np.float32, kernels: ScanKernels
) -> tuple[Image, Image]:
    """Return gradients (L, n, 3) and smooth grey levels (L, n), not scaled; `sign` turns v up."""
    width = pixels.shape[1]
    gaussian, derivative, region = kernels.gaussian, kernels.derivative, kernels.region
    radius, region_radius = len(gaussian) // 2, len(region) // 2
    margin = max(radius, region_radius)
    smooth = np.empty(width + 2 * margin, np.float32)
    slope = np.empty(width + 2 * margin, np.float32)
    wide = np.empty(width + 2 * margin, np.float32)
    modulus = np.empty(width + 2, np.float32)
    along = np.empty(width, np.float32)
    across = np.empty(width, np.float32)
    turning = np.zeros(width, np.float32)
    gradients = np.empty((len(lines), width, 3), np.float32)
    levels = np.zeros((len(lines), width), np.float32)
    for line in range(len(lines)):
        row = lines[line]
        fold_across(pixels, row, gaussian, derivative, smooth[margin:], slope[margin:])
        mirror_ends(smooth, margin, width)
        mirror_ends(slope, margin, width)
        antisymmetric_along(smooth, margin, derivative, along)
        symmetric_along(slope, margin, gaussian, across)
        for x in range(width):
            across[x] *= sign
        if len(region):
            sum_across(pixels, row, region, wide[margin:])
            mirror_ends(wide, margin, width)
            symmetric_along(wide, margin, region, levels[line])
            for x in range(width):
                modulus[x + 1] = np.sqrt(along[x] * along[x] + across[x] * across[x])
            mirror_ends(modulus, 1, width)
            for x in range(width):
                turning[x] = np.float32(0.5) * (modulus[x + 2] - modulus[x])
        # All channels in one loop: then the processor writes many points at a time.
        for x in range(width):
            gradients[line, x, ALONG] = along[x]
            gradients[line, x, ACROSS] = across[x]
            gradients[line, x, SLOPE] = turning[x]
    return gradients, levels


class ScanLines(NamedTuple):
    """Measures along one family of parallel scan lines.

    Rows are scanned to the right, columns upwards: u is the coordinate along a line, v that of the
    line, in the image frame of the working picture.

    Attributes
    ----------
    gradients : Image
        float32, shape (L, n, 3), see `ALONG`: gradient along u and along v [robust scales], slope
        of its modulus along u [robust scales per px].
    smooth : Image
        Grey level without the fine texture [scales of the contrast], float32, shape (L, n).
    places : FloatArray
        v of each line [px], shape (L,).
    """

    gradients: Image
    smooth: Image
    places: FloatArray


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
