"""Gradients of a frame along its scan lines, worked out once and read at many points.

Borders are not measured everywhere, but where they cross rows of the picture, `sample_spacing`
apart, or such columns if they run flat: only there are the gradients worked out. Along such a line,
everything that is asked of a border (is there an edge, is it here, what lies beside it) is found at
other places of the same line.

Two things are known of an edge: the gradient of the smoothed picture, and the slope of its modulus.
The first, projected on the normal of a line, is the response of a derivative-of-Gaussian filter
across that line. The second tells how far away the edge is: it is zero on the edge itself.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.measure.gradients.gradient_shape import (
    ROUND,
    GradientShape,
    gradient_shape,
)
from cable_tracker.cable.measure.gradients.scan_filters import (
    ScanKernels,
    antisymmetric_along,
    fold_across,
    mirror_ends,
    sum_across,
    symmetric_along,
)
from cable_tracker.cable.measure.gradients.scan_lines import ACROSS, ALONG, SLOPE, ScanLines
from cable_tracker.compilation import (
    compiled,
    compiled_fast_loop,
    compiled_fast_part,
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
