"""Separable filters of the scan lines: Gaussians and their derivatives, mirrored at the edges."""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import Float32Array, FloatArray, Image
from cable_tracker.compilation import compiled_fast_loop, compiled_loop

REACH = 3.0
"""Half-width of the filters, in sigma."""


class ScanKernels(NamedTuple):
    """The filters, float32, of odd length.

    Attributes
    ----------
    gaussian, derivative : Float32Array
        Smoothing filter, and its derivative, of the same length; the derivative's answer to a ramp
        of slope one is one.
    region : Float32Array
        Wide smoothing filter, which takes away the fine texture; shape (0,) where only gradients
        are asked for: all other measures are zero then.
    contrast_lag : int
        Distance of the places whose difference is the contrast [px].
    """

    gaussian: Float32Array
    derivative: Float32Array
    region: Float32Array
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


@compiled_fast_loop
def fold_across(
    pixels: Image,
    row: int,
    gaussian: Float32Array,
    derivative: Float32Array,
    smooth: Image,
    slope: Image,
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
def sum_across(pixels: Image, row: int, kernel: Float32Array, sums: Image) -> None:
    """Apply a symmetric filter down the columns at a row; fill in the sums (n,)."""
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
def mirror_ends(padded: Image, margin: int, width: int) -> None:
    """Fill in the margins of a line of `width` values by its mirror image."""
    for step in range(1, margin + 1):
        padded[margin - step] = padded[margin + mirrored(-step, width)]
        padded[margin + width - 1 + step] = padded[margin + mirrored(width - 1 + step, width)]


@compiled_fast_loop
def symmetric_along(padded: Image, margin: int, kernel: Float32Array, answers: Image) -> None:
    """Apply a symmetric filter along a line with margins; fill in the answers (n,)."""
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
def antisymmetric_along(padded: Image, margin: int, kernel: Float32Array, answers: Image) -> None:
    """Apply an antisymmetric filter along a line with margins; fill in the answers (n,)."""
    radius = len(kernel) // 2
    width = len(answers)
    for x in range(width):
        answers[x] = np.float32(0.0)
    for tap in range(1, radius + 1):
        weight = kernel[radius + tap]
        before, after = padded[margin - tap :], padded[margin + tap :]
        for x in range(width):
            answers[x] += weight * (after[x] - before[x])
