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

import math
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.measure.gradient_shape import ROUND, GradientShape, gradient_shape
from cable_tracker.cable.measure.robust_scale import robust_scale
from cable_tracker.compilation import (
    compiled,
    compiled_fast_loop,
    compiled_fast_part,
    compiled_loop,
    compiled_part,
)

NOISE_FLOOR = 0.1
"""Smallest robust scale of a frame [grey levels per px]: below it lies the rounding of pixels."""

SMALLEST_CONTRAST = 0.3
"""Smallest scale of the contrast [grey levels]."""

SCALE_STEP = 8
"""Robust scales are taken over every eighth point of the scan lines: they say the same as all."""

DARK = 6.0
"""Added to grey levels before gradients are divided by them [grey levels]: below, all is noise."""

MOST_TEXTURE = 1.5
"""Upper bound of the gradient over the grey level in sums of texture, in units of the robust scale
over the mean grey level: edges are no texture, and a flat picture has none."""

TEXTURE_STEP = 2
"""Texture is known of every second scan line: they say the same as all."""

REACH = 3.0
"""Half-width of the filters, in sigma."""


ALONG, ACROSS, SLOPE = range(3)
"""Channels: the last axis of `ScanLines.gradients`."""


class ScanKernels(NamedTuple):
    """The filters, float32, of odd length.

    Attributes
    ----------
    gaussian, derivative : Image
        Of one length: the smoothing filter, and its derivative, which answers a ramp of slope one
        with one.
    region : Image
        The wide smoothing filter, without the fine texture; shape (0,) where gradients alone are
        looked at: all other measures are zero then.
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


class ScanLines(NamedTuple):
    """What is known along parallel scan lines.

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
    texture : Image
        Sums of gradients over grey levels along every `TEXTURE_STEP`-th line, the first one among
        them, float32, shape (ceil(L / 2), n + 1): the difference of two is the sum over the pixels
        between.
    """

    gradients: Image
    smooth: Image
    places: FloatArray
    texture: Image


@dataclass(frozen=True, slots=True, eq=False)
class ScannedFrame:
    """Rows and columns of a frame.

    Attributes
    ----------
    rows, columns : ScanLines
        Scan lines along which steep and flat borders are measured.
    scale : float
        Robust standard deviation of the gradient over the frame [grey levels per px]. A cable
        covers too little of it to move the median.
    contrast_scale : float
        Robust standard deviation of the smoothed picture over a few pixels [grey levels]: what slow
        changes of the light alone make of the inside and the outside of a border.
    shape : GradientShape
        Covariance of the gradients; the identity where only gradients are asked for.
    """

    rows: ScanLines
    columns: ScanLines
    scale: float
    contrast_scale: float
    shape: GradientShape


def line_indices(length: int, spacing: int) -> IndexArray:
    """Return which rows of a picture of this height [px] are scanned: centred, `spacing` apart."""
    count = (length - 1) // spacing + 1
    first = (length - 1 - (count - 1) * spacing) // 2
    return np.arange(count, dtype=np.int64) * spacing + first


def scan_frame(picture: Image, spacing: int, kernels: ScanKernels) -> ScannedFrame:
    """Work out the gradients along the scan lines of a picture.

    Parameters
    ----------
    picture : Image
        Grey levels, uint8 or float32, shape (h, w).
    spacing : int
        Distance between the lines [px].
    kernels : ScanKernels
        The filters. Their `contrast_lag` must be shorter than the longer side of the picture.
    """
    height, width = picture.shape
    rows, columns = line_indices(height, spacing), line_indices(width, spacing)
    # Columns are scanned upwards: the rows of this one are the columns of that, from below.
    turned = np.asarray(cv2.rotate(picture, cv2.ROTATE_90_CLOCKWISE))
    # One kind of array: for bytes, and for frames that cannot be written to, Numba would compile
    # anew.
    pixels, turned = (np.require(each, np.float32, ("C", "W", "A")) for each in (picture, turned))
    places = (height - 1) / 2 - rows, columns - (width - 1) / 2
    return ScannedFrame(*_scan_both(pixels, turned, rows, columns, places, kernels))


@compiled
def _scan_both(
    pixels: Image,
    turned: Image,
    rows: IndexArray,
    columns: IndexArray,
    places: tuple[FloatArray, FloatArray],
    kernels: ScanKernels,
) -> tuple[ScanLines, ScanLines, float, float, GradientShape]:
    """Return what `ScannedFrame` holds; `places` of the rows and of the columns."""
    # Rows run down where v runs up.
    gradients, smooth = _scan(pixels, rows, np.float32(-1.0), kernels)
    turned_gradients, turned_smooth = _scan(turned, columns, np.float32(1.0), kernels)
    ordinary = _gradient_scale(gradients, turned_gradients)
    scale = max(ordinary, NOISE_FLOOR)
    if not len(kernels.region):
        _multiply(gradients.reshape(-1), np.float32(1.0 / scale))
        _multiply(turned_gradients.reshape(-1), np.float32(1.0 / scale))
        return (
            ScanLines(gradients, smooth, places[0], smooth),
            ScanLines(turned_gradients, turned_smooth, places[1], turned_smooth),
            scale,
            SMALLEST_CONTRAST,
            ROUND,
        )
    contrast_scale = _contrast_scale(smooth, turned_smooth, kernels.contrast_lag)
    contrast_scale = max(contrast_scale, SMALLEST_CONTRAST)
    for values, unit in (
        (gradients.reshape(-1), scale),
        (turned_gradients.reshape(-1), scale),
        (smooth.reshape(-1), contrast_scale),
        (turned_smooth.reshape(-1), contrast_scale),
    ):
        _multiply(values, np.float32(1.0 / unit))
    dark = DARK / contrast_scale
    most = MOST_TEXTURE * ordinary / scale / (max(_mean(smooth.reshape(-1)), 0.0) + dark)
    texture = summed_texture(gradients, smooth, dark, most)
    turned_texture = summed_texture(turned_gradients, turned_smooth, dark, most)
    return (
        ScanLines(gradients, smooth, places[0], texture),
        ScanLines(turned_gradients, turned_smooth, places[1], turned_texture),
        scale,
        contrast_scale,
        gradient_shape(gradients, turned_gradients),
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
    """Return the robust scale of differences along the lines, over a lag [grey levels]."""
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


@compiled_fast_loop
def _mean(values: Image) -> float:
    total = 0.0
    for value in values:
        total += value
    return total / len(values)


@compiled_part
def summed_texture(gradients: Image, smooth: Image, dark: float, most: float) -> Image:
    """Return the sums of gradients over grey levels along scan lines, see `ScanLines`.

    Parameters
    ----------
    gradients, smooth : Image
        See `ScanLines`.
    dark : float
        Added to the grey levels [scales of the contrast].
    most : float
        A gradient over the grey level counts no more.
    """
    lines, length = smooth.shape
    sums = np.empty(((lines - 1) // TEXTURE_STEP + 1, length + 1), np.float32)
    for number in range(len(sums)):
        line = TEXTURE_STEP * number
        _fill_texture(
            gradients[line], smooth[line], np.float32(dark), np.float32(most), sums[number]
        )
    return sums


@compiled_fast_loop
def _fill_texture(
    gradients: Image, smooth: Image, dark: np.float32, most: np.float32, sums: Image
) -> None:
    """Fill in the sums (n + 1,) along one line."""
    sums[0] = np.float32(0.0)
    for x in range(len(smooth)):
        along, across = gradients[x, ALONG], gradients[x, ACROSS]
        level = max(smooth[x], np.float32(0.0)) + dark
        sums[x + 1] = min(np.sqrt(along * along + across * across) / level, most)
    for x in range(len(smooth)):
        sums[x + 1] += sums[x]


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
    gradients = np.zeros((len(lines), width, 3), np.float32)
    levels = np.zeros((len(lines), width), np.float32)
    for line in range(len(lines)):
        row = lines[line]
        _fold_across(pixels, row, gaussian, derivative, smooth[margin:], slope[margin:])
        _mirror_ends(smooth, margin, width)
        _mirror_ends(slope, margin, width)
        _antisymmetric_along(smooth, margin, derivative, along)
        _symmetric_along(slope, margin, gaussian, across)
        for x in range(width):
            across[x] *= sign
            gradients[line, x, ALONG] = along[x]
            gradients[line, x, ACROSS] = across[x]
        if not len(region):
            continue
        _sum_across(pixels, row, region, wide[margin:])
        _mirror_ends(wide, margin, width)
        _symmetric_along(wide, margin, region, levels[line])
        for x in range(width):
            modulus[x + 1] = np.sqrt(along[x] * along[x] + across[x] * across[x])
        _mirror_ends(modulus, 1, width)
        for x in range(width):
            gradients[line, x, SLOPE] = np.float32(0.5) * (modulus[x + 2] - modulus[x])
    return gradients, levels


@compiled_fast_loop
def _fold_across(
    pixels: Image, row: int, gaussian: Image, derivative: Image, smooth: Image, slope: Image
) -> None:
    """Apply the symmetric and the antisymmetric filter down the columns at a row."""
    height, width = pixels.shape
    radius = len(gaussian) // 2
    here, centre = pixels[row], gaussian[radius]
    for x in range(width):
        smooth[x] = centre * np.float32(here[x])
        slope[x] = np.float32(0.0)
    for tap in range(1, radius + 1):
        before, after = pixels[mirrored(row - tap, height)], pixels[mirrored(row + tap, height)]
        weight, change = gaussian[radius + tap], derivative[radius + tap]
        for x in range(width):
            first, second = np.float32(before[x]), np.float32(after[x])
            smooth[x] += weight * (second + first)
            slope[x] += change * (second - first)


@compiled_fast_loop
def _sum_across(pixels: Image, row: int, kernel: Image, sums: Image) -> None:
    height, width = pixels.shape
    radius = len(kernel) // 2
    here, centre = pixels[row], kernel[radius]
    for x in range(width):
        sums[x] = centre * np.float32(here[x])
    for tap in range(1, radius + 1):
        before, after = pixels[mirrored(row - tap, height)], pixels[mirrored(row + tap, height)]
        weight = kernel[radius + tap]
        for x in range(width):
            sums[x] += weight * (np.float32(before[x]) + np.float32(after[x]))


@compiled_loop
def mirrored(index: int, length: int) -> int:
    """Fold an index beyond either end back inside, the end itself not repeated."""
    period = max(2 * (length - 1), 1)
    folded = index % period
    return folded if folded < length else period - folded


@compiled_loop
def _mirror_ends(padded: Image, margin: int, width: int) -> None:
    for step in range(1, margin + 1):
        padded[margin - step] = padded[margin + mirrored(-step, width)]
        padded[margin + width - 1 + step] = padded[margin + mirrored(width - 1 + step, width)]


@compiled_fast_loop
def _symmetric_along(padded: Image, margin: int, kernel: Image, answers: Image) -> None:
    radius = len(kernel) // 2
    width = len(answers)
    here, centre = padded[margin:], kernel[radius]
    for x in range(width):
        answers[x] = centre * here[x]
    for tap in range(1, radius + 1):
        weight = kernel[radius + tap]
        before, after = padded[margin - tap :], padded[margin + tap :]
        for x in range(width):
            answers[x] += weight * (after[x] + before[x])


@compiled_fast_loop
def _antisymmetric_along(padded: Image, margin: int, kernel: Image, answers: Image) -> None:
    radius = len(kernel) // 2
    width = len(answers)
    for x in range(width):
        answers[x] = np.float32(0.0)
    for tap in range(1, radius + 1):
        weight = kernel[radius + tap]
        before, after = padded[margin - tap :], padded[margin + tap :]
        for x in range(width):
            answers[x] += weight * (after[x] - before[x])
