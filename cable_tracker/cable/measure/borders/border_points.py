"""What is measured where a border crosses the scan lines of a frame.

A steep border is measured where it crosses rows, a flat one where it crosses columns. Crossings are
measured many at a time, step by step, so that the processor works out several at once: where they
are, `find_crossings`, how the picture changes there, `measure_responses`, and how bright it is on
both sides, `measure_contrasts`. These serve the likelihood ratio, the thesis and learning alike.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import Float32Array, FloatArray
from cable_tracker.cable.measure.scanned_gradients import (
    ACROSS,
    ALONG,
    SLOPE,
    ScanInputs,
    ScanLines,
    directional_gain,
)
from cable_tracker.cable.model.geometry import border_offset
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, WIDTH
from cable_tracker.compilation import compiled_inside, compiled_part

BEHIND = 0.25
"""Depth behind the border at which the first inside level is read, as a share of the width; the
second is read at half the width."""

NEAREST, FARTHEST_BEHIND, FARTHEST_MIDDLE = 3.0, 12.0, 40.0
"""Minimum of both depths, maximum of the first, of the second [px at the reference width]."""

OUTSIDE = 6.0
"""Distance before the border at which the outside level is read [px at the reference width]."""

MINIMUM_LENGTH = 3.0
"""Minimum length of a border inside the image for a claim [distances of the scan lines]."""

SMALLEST_RESPONSE = np.float32(1.0)
"""Added to a response before its slope is divided by it [robust scales]: noise has no ridge."""

BLOCK, GROUP = 64, 16
"""Crossings per block (buffer length), and the multiple to which a block is padded for SIMD."""


class BorderLine(NamedTuple):
    """A border as it crosses one family of scan lines.

    Attributes
    ----------
    is_steep : bool
        It is measured where it crosses rows, else where it crosses columns.
    inward : float
        Component along the lines of its normal that points into the cable.
    start, step : float
        It crosses the line at v in u = start + step v, u from the middle of the line [working px].
    length : float
        Length of border that a crossing stands for [distances of the scan lines], at least 1.
    along, across : float32
        Inward normal along and across the lines, times the gain of responses.
    slope_factor : float32
        Factor on slopes along the line, which gives them along the normal per px at the reference
        width.
    outside, behind, deep : float
        Positions of the outside and the two inside levels, along the line from the crossing
        [working px], plus half a pixel, so that rounding down gives the nearest pixel.
    """

    is_steep: bool
    inward: float
    start: float
    step: float
    length: float
    along: np.float32
    across: np.float32
    slope_factor: np.float32
    outside: float
    behind: float
    deep: float


class Crossings(NamedTuple):
    """Room for the crossings of a border with up to `BLOCK` neighbouring scan lines.

    Attributes
    ----------
    positions : FloatArray
        Positions from the left end of their line [working px], shape (BLOCK,).
    pixels : NDArray[np.uint32]
        Indices, shape (4, BLOCK): `measure_responses` row 0, the pixel to the left;
        `measure_contrasts` rows 0 to 2, the pixels outside, behind and deep; afterwards row 0, the
        cell of the table of ratios.
    levels : Float32Array
        Values read from the line, float32, shape (3, BLOCK): in `measure_responses` gradient along
        the line, gradient across it, slope; from `measure_contrasts` on the grey levels outside,
        behind and deep.
    shares : Float32Array
        Fractions of a pixel from the pixel to the left, float32, shape (BLOCK,).
    responses, slopes, contrasts : Float32Array
        Response across the border and contrast, in their robust scales, positive where the inside
        is brighter; slope over the response [1/px at the reference width]. float32, shape (BLOCK,).
    """

    positions: FloatArray
    pixels: NDArray[np.uint32]
    levels: Float32Array
    shares: Float32Array
    responses: Float32Array
    slopes: Float32Array
    contrasts: Float32Array


@compiled_part
def room_for_crossings() -> Crossings:
    """Return room for crossings."""
    return Crossings(
        np.zeros(BLOCK),
        np.zeros((4, BLOCK), np.uint32),
        np.zeros((3, BLOCK), np.float32),
        np.zeros(BLOCK, np.float32),
        np.zeros(BLOCK, np.float32),
        np.zeros(BLOCK, np.float32),
        np.zeros(BLOCK, np.float32),
    )


@compiled_inside
def width_across(state: FloatArray, reduction: float) -> float:
    """Return the width of a cable across its borders [working px]; state (8,)."""
    return float(abs(state[WIDTH] * math.cos(state[SKEW])) * reduction)


@compiled_inside
def contrast_depths(width: float, scale: float) -> tuple[float, float, float]:
    """Return how far outside, behind the border and in the middle is looked at [working px]."""
    return (
        OUTSIDE * scale,
        min(max(BEHIND * width, NEAREST * scale), FARTHEST_BEHIND * scale),
        min(max(0.5 * width, NEAREST * scale), FARTHEST_MIDDLE * scale),
    )


@compiled_inside
def border_line(state: FloatArray, side: float, scan: ScanInputs) -> BorderLine:
    """Return how a border of a cable, shape (8,), crosses the scan lines of a frame.

    `side`: -1 for the left border, 1 for the right one.
    """
    normal = state[ANGLE] + side * state[SKEW]
    offset = border_offset(state[DISTANCE], state[WIDTH], state[SKEW], side) * scan.reduction
    x, y = math.cos(normal), math.sin(normal)
    is_steep = abs(x) >= abs(y)
    along, across = (x, y) if is_steep else (y, x)
    inward, gain = -side * along, directional_gain(scan.shape, x, y)
    along_per_px = 1.0 / inward
    outside, behind, deep = contrast_depths(width_across(state, scan.reduction), scan.scale)
    return BorderLine(
        is_steep,
        inward,
        offset / along,
        -across / along,
        1.0 / abs(along),
        np.float32(inward * gain),
        np.float32(-side * across * gain),
        np.float32(scan.scale / along * gain),
        0.5 - outside * along_per_px,
        0.5 + behind * along_per_px,
        0.5 + deep * along_per_px,
    )


@compiled_inside
def find_crossings(
    lines: ScanLines, start: int, border: BorderLine, crossings: Crossings
) -> tuple[int, int]:
    """Fill in where a border crosses up to `BLOCK` lines from `start` on, inside the picture.

    Returns
    -------
    (int, int)
        The first line that it crosses, and how many one after the other.
    """
    positions, middle = crossings.positions, _last_pixel(lines) / 2
    places = lines.places[start : start + BLOCK]
    for index in range(len(places)):
        place = border.start + border.step * places[index]
        # Written so that a place that is no number is outside.
        positions[index] = place + middle if abs(place) <= middle else -1.0
    first, stop = 0, len(places)
    while first < stop and positions[first] < 0.0:
        first += 1
    while stop > first and positions[stop - 1] < 0.0:
        stop -= 1
    count = stop - first
    for index in range(count):
        positions[index] = positions[first + index]
    for index in range(count, padded_count(count)):
        positions[index] = 0.0
    return start + first, count


@compiled_inside
def padded_count(count: int) -> int:
    """Return `count` rounded up to a multiple of `GROUP`, so that whole SIMD registers are filled.

    Values of the padding beyond `count` are not used.
    """
    return (count + GROUP - 1) // GROUP * GROUP


@compiled_inside
def _last_pixel(lines: ScanLines) -> float:
    return float(lines.smooth.shape[1] - 1)


@compiled_inside
def measure_responses(
    lines: ScanLines, first: int, count: int, border: BorderLine, crossings: Crossings
) -> None:
    """Fill in responses and sizes of slopes at crossings with the lines from `first` on.

    They are interpolated between the two neighbouring pixels of the line.
    """
    positions, left, shares = crossings.positions, crossings.pixels[0], crossings.shares
    along, across, slope = crossings.levels[0], crossings.levels[1], crossings.levels[2]
    # A picture may be one pixel high.
    last = _last_pixel(lines)
    most, right = max(last - 1.0, 0.0), np.uint64(min(last, 1.0))
    for index in range(padded_count(count)):
        pixel = np.int32(min(positions[index], most))
        left[index] = np.uint32(pixel)
        shares[index] = np.float32(positions[index] - pixel)
    for index in range(count):
        here = lines.gradients[np.uint64(first + index), np.uint64(left[index])]
        there = lines.gradients[np.uint64(first + index), np.uint64(left[index]) + right]
        share = shares[index]
        along[index] = here[ALONG] + (there[ALONG] - here[ALONG]) * share
        across[index] = here[ACROSS] + (there[ACROSS] - here[ACROSS]) * share
        slope[index] = here[SLOPE] + (there[SLOPE] - here[SLOPE]) * share
    for index in range(padded_count(count)):
        response = border.along * along[index] + border.across * across[index]
        size = abs(border.slope_factor * slope[index])
        crossings.responses[index] = response
        crossings.slopes[index] = size / (abs(response) + SMALLEST_RESPONSE)


@compiled_inside
def measure_contrasts(
    lines: ScanLines, first: int, count: int, border: BorderLine, crossings: Crossings
) -> None:
    """Fill in contrasts at crossings with the lines from `first` on.

    Beyond the ends of a line its last level goes on.
    """
    positions, last = crossings.positions, _last_pixel(lines)
    pixels, levels = crossings.pixels, crossings.levels
    for index in range(padded_count(count)):
        pixels[0, index] = pixel_at(positions[index] + border.outside, last)
        pixels[1, index] = pixel_at(positions[index] + border.behind, last)
        pixels[2, index] = pixel_at(positions[index] + border.deep, last)
    for index in range(count):
        line = lines.smooth[np.uint64(first + index)]
        levels[0, index] = line[np.uint64(pixels[0, index])]
        levels[1, index] = line[np.uint64(pixels[1, index])]
        levels[2, index] = line[np.uint64(pixels[2, index])]
    for index in range(padded_count(count)):
        without = levels[0, index]
        crossings.contrasts[index] = weaker_common_contrast(
            levels[1, index] - without, levels[2, index] - without
        )


@compiled_inside
def pixel_at(position: float, last: float) -> np.uint32:
    """Return the pixel of a line that a position, rounded down, falls on, up to the last one.

    Without a sign, an index is not checked for counting from the end; with one, the processor
    converts faster.
    """
    return np.uint32(np.int32(min(max(position, 0.0), last)))


@compiled_inside
def weaker_common_contrast(behind: np.float32, middle: np.float32) -> np.float32:
    """Return the contrast of smaller size, inside less outside; 0 where the two have other signs.

    A furrow has dark borders too, but what lies between them is bottom: the inside is looked at
    close behind the border and in the middle of the cable, and the smaller contrast counts.
    """
    # Without a branch, which could not be predicted: whichever of the two is zero adds nothing.
    nothing = np.float32(0.0)
    return max(min(behind, middle), nothing) + min(max(behind, middle), nothing)
