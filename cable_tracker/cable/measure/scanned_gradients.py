"""Gradients of a frame along its scan lines, worked out once and read at many points.

Borders are not measured everywhere, but where they cross every tenth row of the picture or so, or
every tenth column if they run flat: only there are the gradients worked out. Along such a line,
everything that is asked of a border (is there an edge, is it here, what lies beside it) is found at
other places of the same line.

Two things are known of an edge: the gradient of the smoothed picture, and the slope of its modulus.
The first, projected on the normal of a line, is the response of a derivative-of-Gaussian filter
across that line. The second tells how far away the edge is: on its ridge it vanishes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from functools import cache

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray

GAUSSIAN_MAD = 1.4826
"""Standard deviation of a Gaussian over its median absolute deviation."""

NOISE_FLOOR = 0.1
"""Smallest robust scale of a frame [grey levels per px]: below it lies the rounding of pixels."""

SMALLEST_CONTRAST = 0.3
"""Smallest scale of the contrast [grey levels]."""

SCALE_STEP = 8
"""Robust scales are taken over every eighth point of the scan lines: they say the same as all."""

REACH = 3.0
"""Filters end at so many sigma."""

NOTHING = np.array([1.0], np.float32)
DIFFERENCE = np.array([-0.5, 0.0, 0.5], np.float32)


class Channel(IntEnum):
    """Last axis of `ScanLines.gradients`."""

    ALONG = 0
    ACROSS = 1
    SLOPE = 2


@dataclass(frozen=True, slots=True, eq=False)
class ScanKernels:
    """The filters, float32, of odd length.

    Attributes
    ----------
    gaussian, derivative : Image
        Of one length: the smoothing filter, and its derivative, which answers a ramp of slope one
        with one.
    region : Image
        The wide smoothing filter, without the fine texture.
    contrast_lag : int
        Distance of the places whose difference is the contrast [px].
    """

    gaussian: Image
    derivative: Image
    region: Image
    contrast_lag: int


@cache
def scan_kernels(sigma: float, region_sigma: float, contrast_lag: int) -> ScanKernels:
    """Return the filters for two sigmas [px]."""
    x = _taps(sigma)
    gaussian = _gaussian(x, sigma)
    derivative = x * gaussian
    return ScanKernels(
        gaussian.astype(np.float32),
        (derivative / float(derivative @ x)).astype(np.float32),
        _gaussian(_taps(region_sigma), region_sigma).astype(np.float32),
        contrast_lag,
    )


def _taps(sigma: float) -> FloatArray:
    radius = max(1, math.ceil(REACH * sigma))
    return np.arange(-radius, radius + 1, dtype=np.float64)


def _gaussian(x: FloatArray, sigma: float) -> FloatArray:
    values = np.exp(-0.5 * (x / sigma) ** 2)
    normalised: FloatArray = values / values.sum()
    return normalised


@dataclass(frozen=True, slots=True, eq=False)
class ScanLines:
    """What is known along parallel scan lines.

    Rows are scanned to the right, columns upwards: u is the coordinate along a line, v that of the
    line, in the image frame of the working picture.

    Attributes
    ----------
    gradients : Image
        float32, shape (L, n, 3), see `Channel`: gradient along u and along v [robust scales], slope
        of its modulus along u [robust scales per px].
    smooth : Image
        Grey level without the fine texture [scales of the contrast], float32, shape (L, n).
    places : FloatArray
        v of each line [px], shape (L,).
    """

    gradients: Image
    smooth: Image
    places: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class ScannedFrame:
    """Rows and columns of a frame.

    Attributes
    ----------
    rows, columns : ScanLines
        Where steep and where flat borders are measured.
    scale : float
        Robust standard deviation of the gradient over the frame [grey levels per px]. A cable
        covers too little of it to move the median.
    contrast_scale : float
        Robust standard deviation of the smoothed picture over a few pixels [grey levels]: what slow
        changes of the light alone make of the inside and the outside of a border.
    """

    rows: ScanLines
    columns: ScanLines
    scale: float
    contrast_scale: float


def line_indices(length: int, spacing: int) -> IndexArray:
    """Return which rows of a picture of this height [px] are scanned: centred, `spacing` apart."""
    count = (length - 1) // spacing + 1
    first = (length - 1 - (count - 1) * spacing) // 2
    return np.arange(count, dtype=np.int64) * spacing + first


def scan_frame(pixels: Image, spacing: int, kernels: ScanKernels) -> ScannedFrame:
    """Work out the gradients along the scan lines of a picture.

    Parameters
    ----------
    pixels : Image
        Grey levels, uint8 or float32, shape (h, w).
    spacing : int
        Distance between the lines [px].
    kernels : ScanKernels
        The filters. Their `contrast_lag` must be shorter than the longer side of the picture.
    """
    height, width = pixels.shape
    rows, columns = line_indices(height, spacing), line_indices(width, spacing)
    # Columns are scanned upwards: the rows of this one are the columns of that, from below.
    turned = pixels[::-1].T
    row_gradients, row_smooth = _scan(pixels, rows, kernels)
    column_gradients, column_smooth = _scan(turned, columns, kernels)
    # Rows run down where v runs up.
    row_gradients[..., Channel.ACROSS] *= -1.0
    scale = _robust_scale((row_gradients, column_gradients))
    contrast_scale = _contrast_scale((row_smooth, column_smooth), kernels.contrast_lag)
    gradient_factor, factor = np.float32(1.0 / scale), np.float32(1.0 / contrast_scale)
    return ScannedFrame(
        ScanLines(row_gradients * gradient_factor, row_smooth * factor, (height - 1) / 2 - rows),
        ScanLines(
            column_gradients * gradient_factor, column_smooth * factor, columns - (width - 1) / 2
        ),
        scale,
        contrast_scale,
    )


def _scan(pixels: Image, lines: IndexArray, kernels: ScanKernels) -> tuple[Image, Image]:
    smooth = _filter_across(pixels, lines, kernels.gaussian)
    along = _filter_along(smooth, kernels.derivative)
    across = _filter_along(_filter_across(pixels, lines, kernels.derivative), kernels.gaussian)
    region = _filter_along(_filter_across(pixels, lines, kernels.region), kernels.region)
    slope = _filter_along(np.sqrt(along * along + across * across), DIFFERENCE)
    return np.stack((along, across, slope), axis=-1), region


def _filter_across(pixels: Image, lines: IndexArray, kernel: Image) -> Image:
    """Correlate down the columns, at some rows only; rows beyond the edge are mirrored."""
    radius = len(kernel) // 2
    rows = mirrored(lines[:, None] + np.arange(-radius, radius + 1), pixels.shape[0])
    answers: Image = kernel @ pixels[rows].astype(np.float32)
    return answers


def _filter_along(lines: Image, kernel: Image) -> Image:
    return np.asarray(
        cv2.sepFilter2D(lines, cv2.CV_32F, kernel, NOTHING, borderType=cv2.BORDER_REFLECT_101)
    )


def mirrored(indices: IndexArray, length: int) -> IndexArray:
    """Fold indices beyond either end back inside, the end itself not repeated; any shape."""
    period = max(2 * (length - 1), 1)
    folded = np.mod(indices, period)
    inside: IndexArray = np.where(folded < length, folded, period - folded)
    return inside


def _robust_scale(families: tuple[Image, ...]) -> float:
    samples = [each[:, ::SCALE_STEP, : Channel.SLOPE].ravel() for each in families]
    return max(GAUSSIAN_MAD * float(np.median(np.abs(np.concatenate(samples)))), NOISE_FLOOR)


def _contrast_scale(families: tuple[Image, ...], lag: int) -> float:
    samples = []
    for smooth in families:
        first = smooth[:, : -lag or None : SCALE_STEP]
        second = smooth[:, lag::SCALE_STEP]
        samples.append(np.abs(second - first[:, : second.shape[1]]).ravel())
    return max(GAUSSIAN_MAD * float(np.median(np.concatenate(samples))), SMALLEST_CONTRAST)
