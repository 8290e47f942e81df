"""What is measured where a border crosses the scan lines of a frame.

A steep border is measured where it crosses rows, a flat one where it crosses columns. One kernel
looks at a point, `measure_point`; it serves the likelihood ratio and learning alike.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.measure.response_bins import PointMeasures
from cable_tracker.cable.measure.scanned_gradients import ACROSS, ALONG, SLOPE, ScanLines
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.geometry import border_offset
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, WIDTH
from cable_tracker.compilation import compiled, compiled_inside

BEHIND = 0.25
"""The inside is looked at so deep behind the border, as a share of the cable's width ..."""

NEAREST, FARTHEST_BEHIND, FARTHEST_MIDDLE = 3.0, 12.0, 40.0
"""... and in the middle, within these limits [px at the reference width]."""

OUTSIDE = 6.0
"""The outside is looked at so far from the border [px at the reference width]."""

MINIMUM_POINTS = 3.0
"""A border with fewer points inside the image shows nothing."""

SMALLEST_RESPONSE = np.float32(1.0)
"""Added to a response before its slope is divided by it [robust scales]: noise has no ridge."""


class FrameScan(NamedTuple):
    """What kernels need to know of a frame.

    Attributes
    ----------
    rows, columns : ScanLines
        Where steep and where flat borders are measured.
    reduction : float
        Working pixels per frame pixel.
    scale : float
        Working pixels per pixel of an image of the reference width.
    expected : float
        Points of a border that runs through the picture.
    """

    rows: ScanLines
    columns: ScanLines
    reduction: float
    scale: float
    expected: float


def frame_scan(image: WorkingImage) -> FrameScan:
    """Return what kernels need to know of a frame."""
    scanned = image.scanned
    return FrameScan(
        scanned.rows,
        scanned.columns,
        image.reduction,
        image.scale,
        image.size[1] / image.line_spacing,
    )


class BorderLine(NamedTuple):
    """A border as it crosses one family of scan lines.

    Attributes
    ----------
    start, step : float
        It crosses the line at v in u = start + step v, from the middle of the line [working px].
    length : float
        Length of border that a crossing stands for [distances of the scan lines], at least 1.
    along, across : float32
        Inward normal along and across the lines.
    slope_factor : float32
        Of slopes along the line, to have them along the normal, per px at the reference width.
    outside, behind, deep : float
        Where the contrast is looked at, along the line from the crossing [working px], and half a
        pixel more, which rounds to the nearest.
    """

    start: float
    step: float
    length: float
    along: np.float32
    across: np.float32
    slope_factor: np.float32
    outside: float
    behind: float
    deep: float


class BetweenPixels(NamedTuple):
    """A place on a scan line: the pixels on both sides, and its share of the way to the right."""

    left: np.uint64
    right: np.uint64
    share: np.float32


@compiled_inside
def border_normal(
    state: FloatArray, side: float, reduction: float
) -> tuple[bool, float, float, float]:
    """Return how a border lies to the scan lines; `side`: -1 left, 1 right.

    Whether it is measured where it crosses rows (else columns), its normal along and across these
    lines, and its distance from the image centre [working px].
    """
    normal = state[ANGLE] + side * state[SKEW]
    offset = border_offset(state[DISTANCE], state[WIDTH], state[SKEW], side) * reduction
    cos, sin = math.cos(normal), math.sin(normal)
    if abs(cos) >= abs(sin):
        return True, cos, sin, offset
    return False, sin, cos, offset


@compiled_inside
def working_width(state: FloatArray, reduction: float) -> float:
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
def border_line(
    along: float,
    across: float,
    offset: float,
    inward: float,
    depths: tuple[float, float, float],
    scale: float,
) -> BorderLine:
    """Return how a border crosses its scan lines.

    Parameters
    ----------
    along, across : float
        Its normal, along and across the lines.
    offset : float
        Distance from the image centre [working px].
    inward : float
        1 if the normal points into the cable, else -1.
    depths : (float, float, float)
        See `contrast_depths`.
    scale : float
        See `FrameScan`.
    """
    stretch = inward / along
    return BorderLine(
        offset / along,
        -across / along,
        1.0 / abs(along),
        np.float32(inward * along),
        np.float32(inward * across),
        np.float32(scale / along),
        0.5 - depths[0] * stretch,
        0.5 + depths[1] * stretch,
        0.5 + depths[2] * stretch,
    )


@compiled_inside
def crossing_position(
    lines: ScanLines, line: np.uint64, start: float, step: float, last: float
) -> float:
    """Return where a border crosses a line, counted from its left end up to `last` [working px].

    Negative where it does not; `start` and `step` are those of `BorderLine`.
    """
    middle = last / 2
    place = start + step * lines.places[line]
    # Written so that a place that is no number is outside.
    return place + middle if abs(place) <= middle else -1.0


@compiled_inside
def measure_point(
    lines: ScanLines, line: np.uint64, position: float, last: float, border: BorderLine
) -> tuple[np.float32, np.float32, np.float32]:
    """Return response, size of the slope and contrast at a place of a line, see `PointMeasures`.

    `position` is counted from the left end of the line, up to `last`.
    """
    smooth = lines.smooth
    place = between_pixels(position, smooth.shape[1])
    response = response_at(lines.gradients, line, place, border.along, border.across)
    slope = border.slope_factor * _interpolated(lines.gradients, line, place, SLOPE)
    without = _level_at(smooth, line, position + border.outside, last)
    contrast = agreed_contrast(
        _level_at(smooth, line, position + border.behind, last) - without,
        _level_at(smooth, line, position + border.deep, last) - without,
    )
    return response, abs(slope) / (abs(response) + SMALLEST_RESPONSE), contrast


@compiled_inside
def response_at(
    gradients: Image,
    line: np.uint64,
    place: BetweenPixels,
    along: np.float32,
    across: np.float32,
) -> np.float32:
    """Return the response alone, for a normal given along and across the lines."""
    response: np.float32 = along * _interpolated(
        gradients, line, place, ALONG
    ) + across * _interpolated(gradients, line, place, ACROSS)
    return response


@compiled_inside
def between_pixels(position: float, length: int) -> BetweenPixels:
    """Return between which pixels of a line of some length a place lies that is on it."""
    # A picture may be one pixel high.
    left = min(_floor(position), np.uint64(max(length - 2, 0)))
    right = left + np.uint64(min(length - 1, 1))
    return BetweenPixels(left, right, np.float32(position - left))


@compiled_inside
def _interpolated(
    gradients: Image, line: np.uint64, place: BetweenPixels, channel: int
) -> np.float32:
    """Interpolate a channel between two neighbouring pixels of a line."""
    here, there = gradients[line, place.left, channel], gradients[line, place.right, channel]
    value: np.float32 = here + (there - here) * place.share
    return value


@compiled_inside
def _level_at(smooth: Image, line: np.uint64, position: float, last: float) -> np.float32:
    """Return the level at a place that is rounded down; beyond the ends the last one goes on."""
    level: np.float32 = smooth[line, _floor(min(max(position, 0.0), last))]
    return level


@compiled_inside
def _floor(position: float) -> np.uint64:
    """Return the index of a place that is not negative.

    Without a sign, an index is not checked for counting from the end; with one, the processor
    converts faster.
    """
    return np.uint64(np.int64(position))


@compiled_inside
def agreed_contrast(behind: np.float32, middle: np.float32) -> np.float32:
    """Return how much brighter the inside is than the outside; 0 where its parts disagree.

    A furrow has dark borders too, but what lies between them is bottom: the inside is looked at
    close behind the border and in the middle of the cable, and the smaller contrast counts.
    """
    # Without a branch, which could not be predicted: whichever of the two is zero adds nothing.
    nothing = np.float32(0.0)
    return max(min(behind, middle), nothing) + min(max(behind, middle), nothing)


class BorderPoints(NamedTuple):
    """Where the borders of N cables cross the scan lines of a frame, inside it: P points.

    Attributes
    ----------
    measures : PointMeasures
        What is there, each of shape (P,).
    borders : IndexArray
        Which border it is of: twice the number of the cable, plus one for the right; shape (P,).
    """

    measures: PointMeasures
    borders: IndexArray


def measure_points(states: FloatArray, image: WorkingImage) -> BorderPoints:
    """Measure the frame where the borders of cables, shape (N, 8), cross its scan lines."""
    scan = frame_scan(image)
    most = 2 * len(states) * max(len(scan.rows.places), len(scan.columns.places))
    measures, borders = np.empty((3, most), np.float32), np.empty(most, np.int64)
    count = _record_points(np.array(states, np.float64, order="C"), scan, measures, borders)
    return BorderPoints(PointMeasures(*measures[:, :count].copy()), borders[:count].copy())


@compiled
def _record_points(
    states: FloatArray, scan: FrameScan, measures: Image, borders: IndexArray
) -> int:
    """Fill in measures (3, most) and borders (most,) of the points; return how many there are."""
    count = 0
    for border in range(2 * len(states)):
        state, side = states[border // 2], 2.0 * (border % 2) - 1.0
        depths = contrast_depths(working_width(state, scan.reduction), scan.scale)
        steep, along, across, offset = border_normal(state, side, scan.reduction)
        lines = scan.rows if steep else scan.columns
        crossing = border_line(along, across, offset, -side, depths, scan.scale)
        last = float(lines.smooth.shape[1] - 1)
        for number in range(len(lines.places)):
            line = np.uint64(number)
            position = crossing_position(lines, line, crossing.start, crossing.step, last)
            if position < 0.0:
                continue
            measures[0, count], measures[1, count], measures[2, count] = measure_point(
                lines, line, position, last, crossing
            )
            borders[count] = border
            count += 1
    return count
