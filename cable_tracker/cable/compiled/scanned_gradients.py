"""See `cable_tracker.cable.measure.scanned_gradients`."""

from __future__ import annotations

import cv2
import numpy as np

from cable_tracker.arrays import Image, IndexArray
from cable_tracker.cable.measure.scanned_gradients import (
    GAUSSIAN_MAD,
    NOISE_FLOOR,
    SCALE_STEP,
    SMALLEST_CONTRAST,
    ScanKernels,
    ScanLines,
    ScannedFrame,
    line_indices,
)
from cable_tracker.compilation import compiled, compiled_fast


def scan_frame(pixels: Image, spacing: int, kernels: ScanKernels) -> ScannedFrame:
    """Work out the gradients along the scan lines of a picture (h, w), uint8 or float32."""
    height, width = pixels.shape
    rows, columns = line_indices(height, spacing), line_indices(width, spacing)
    turned = np.asarray(cv2.rotate(pixels, cv2.ROTATE_90_CLOCKWISE))
    filters = (kernels.gaussian, kernels.derivative, kernels.region)
    row_gradients, row_smooth = _scan(pixels, rows, np.float32(-1.0), *filters)
    column_gradients, column_smooth = _scan(turned, columns, np.float32(1.0), *filters)
    scale = _scale_gradients(row_gradients, column_gradients)
    contrast_scale = _scale_contrast(row_smooth, column_smooth, kernels.contrast_lag)
    return ScannedFrame(
        ScanLines(row_gradients, row_smooth, (height - 1) / 2 - rows),
        ScanLines(column_gradients, column_smooth, columns - (width - 1) / 2),
        scale,
        contrast_scale,
    )


@compiled_fast
def _scan(
    pixels: Image,
    lines: IndexArray,
    sign: np.float32,
    gaussian: Image,
    derivative: Image,
    region: Image,
) -> tuple[Image, Image]:
    """Return gradients (L, n, 3) and smooth grey levels (L, n), not scaled; `sign` turns v up."""
    width = pixels.shape[1]
    radius, region_radius = len(gaussian) // 2, len(region) // 2
    margin = max(radius, region_radius)
    smooth = np.empty(width + 2 * margin, np.float32)
    slope = np.empty(width + 2 * margin, np.float32)
    wide = np.empty(width + 2 * margin, np.float32)
    modulus = np.empty(width + 2, np.float32)
    along = np.empty(width, np.float32)
    across = np.empty(width, np.float32)
    gradients = np.empty((len(lines), width, 3), np.float32)
    levels = np.empty((len(lines), width), np.float32)
    for line in range(len(lines)):
        row = lines[line]
        _fold_across(pixels, row, gaussian, derivative, smooth[margin:], slope[margin:])
        _sum_across(pixels, row, region, wide[margin:])
        _mirror_ends(smooth, margin, width)
        _mirror_ends(slope, margin, width)
        _mirror_ends(wide, margin, width)
        _antisymmetric_along(smooth, margin, derivative, along)
        _symmetric_along(slope, margin, gaussian, across)
        _symmetric_along(wide, margin, region, levels[line])
        for x in range(width):
            across[x] *= sign
            modulus[x + 1] = np.sqrt(along[x] * along[x] + across[x] * across[x])
        _mirror_ends(modulus, 1, width)
        for x in range(width):
            gradients[line, x, 0] = along[x]
            gradients[line, x, 1] = across[x]
            gradients[line, x, 2] = np.float32(0.5) * (modulus[x + 2] - modulus[x])
    return gradients, levels


@compiled_fast
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
        before, after = pixels[_mirrored(row - tap, height)], pixels[_mirrored(row + tap, height)]
        weight, change = gaussian[radius + tap], derivative[radius + tap]
        for x in range(width):
            first, second = np.float32(before[x]), np.float32(after[x])
            smooth[x] += weight * (second + first)
            slope[x] += change * (second - first)


@compiled_fast
def _sum_across(pixels: Image, row: int, kernel: Image, sums: Image) -> None:
    height, width = pixels.shape
    radius = len(kernel) // 2
    here, centre = pixels[row], kernel[radius]
    for x in range(width):
        sums[x] = centre * np.float32(here[x])
    for tap in range(1, radius + 1):
        before, after = pixels[_mirrored(row - tap, height)], pixels[_mirrored(row + tap, height)]
        weight = kernel[radius + tap]
        for x in range(width):
            sums[x] += weight * (np.float32(before[x]) + np.float32(after[x]))


@compiled
def _mirrored(index: int, length: int) -> int:
    period = max(2 * (length - 1), 1)
    folded = index % period
    return folded if folded < length else period - folded


@compiled
def _mirror_ends(padded: Image, margin: int, width: int) -> None:
    for step in range(1, margin + 1):
        padded[margin - step] = padded[margin + _mirrored(-step, width)]
        padded[margin + width - 1 + step] = padded[margin + _mirrored(width - 1 + step, width)]


@compiled_fast
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


@compiled_fast
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


@compiled
def _scale_gradients(rows: Image, columns: Image) -> float:
    """Divide gradients by their robust scale, in place, and return it."""
    scale = max(GAUSSIAN_MAD * _median(_moduli(rows, columns)), NOISE_FLOOR)
    _multiply(rows.reshape(-1), np.float32(1.0 / scale))
    _multiply(columns.reshape(-1), np.float32(1.0 / scale))
    return scale


@compiled
def _scale_contrast(rows: Image, columns: Image, lag: int) -> float:
    """Divide smooth grey levels by the robust scale of their contrast, in place; return it."""
    scale = max(GAUSSIAN_MAD * _median(_differences(rows, columns, lag)), SMALLEST_CONTRAST)
    _multiply(rows.reshape(-1), np.float32(1.0 / scale))
    _multiply(columns.reshape(-1), np.float32(1.0 / scale))
    return scale


@compiled
def _multiply(values: Image, factor: np.float32) -> None:
    for index in range(len(values)):
        values[index] *= factor


@compiled
def _median(values: Image) -> float:
    """Return the median of numbers that are not negative, as NumPy does."""
    middle = len(values) // 2
    upper = _at_rank(values, middle)
    if len(values) % 2:
        return float(upper)
    below, lower = _below(values, upper)
    return float(((lower if below == middle else upper) + upper) / np.float32(2.0))


@compiled
def _at_rank(values: Image, rank: int) -> np.float32:
    """Return which of the numbers (none negative) has so many before it in ascending order.

    Such floats are in the order of their bits, which are found one by one, from the highest: to
    count is faster than to sort, for it takes no branch.
    """
    bits = np.zeros(1, np.uint32)
    for bit in range(30, -1, -1):
        bits[0] |= np.uint32(1 << bit)
        if _count_below(values, bits.view(np.float32)[0]) > rank:
            bits[0] ^= np.uint32(1 << bit)
    value: np.float32 = bits.view(np.float32)[0]
    return value


@compiled_fast
def _count_below(values: Image, limit: np.float32) -> np.float32:
    count = np.float32(0.0)
    for index in range(len(values)):
        count += np.float32(1.0) if values[index] < limit else np.float32(0.0)
    return count


@compiled
def _below(values: Image, limit: np.float32) -> tuple[int, np.float32]:
    """Return how many numbers are below a limit, and the largest of them."""
    count, largest = 0, np.float32(0.0)
    for value in values:
        if value < limit:
            count += 1
            largest = max(largest, value)
    return count, largest


@compiled
def _moduli(rows: Image, columns: Image) -> Image:
    samples = np.empty(_samples(rows, 0) * 2 + _samples(columns, 0) * 2, np.float32)
    count = 0
    for gradients in (rows, columns):
        for line in range(gradients.shape[0]):
            for place in range(0, gradients.shape[1], SCALE_STEP):
                samples[count] = abs(gradients[line, place, 0])
                samples[count + 1] = abs(gradients[line, place, 1])
                count += 2
    return samples[:count]


@compiled
def _differences(rows: Image, columns: Image, lag: int) -> Image:
    samples = np.empty(_samples(rows, lag) + _samples(columns, lag), np.float32)
    count = 0
    for smooth in (rows, columns):
        for line in range(smooth.shape[0]):
            for place in range(0, smooth.shape[1] - lag, SCALE_STEP):
                samples[count] = abs(smooth[line, place + lag] - smooth[line, place])
                count += 1
    return samples[:count]


@compiled
def _samples(lines: Image, lag: int) -> int:
    places = max(lines.shape[1] - lag, 0)
    return int(lines.shape[0] * (-(-places // SCALE_STEP)))
