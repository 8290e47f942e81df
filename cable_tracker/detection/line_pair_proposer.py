"""Line pairs of a whole frame, fast enough for every frame of a tracker.

A coarse Hough transform over the gradients that the tracker has worked out anyway. Each strong
gradient votes near its own direction over the full turn, so that the two borders of a cable have
opposite normals. What comes out is a proposal: coarse, often wrong, seldom without the cable.

The constants were chosen on simulated dives of the seeds 200 to 203.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.compilation import (
    compiled,
    compiled_fast_loop,
    compiled_inside,
    compiled_loop,
    compiled_part,
)
from cable_tracker.detection.line_pairs import plausible_pairs
from cable_tracker.detection.pair_limits import DEFAULT_LIMITS, PairLimits

STRONG = 2.0
"""Weaker gradients do not vote [robust scales]."""

VOTE_CAP = 5.0
"""No gradient votes with more: a glint must not outweigh a long border [robust scales]."""

ANGLE_BINS = 120
"""Bins of the accumulator over a full turn."""

BIN = 2.0 * math.pi / ANGLE_BINS
DIRECTIONS = np.stack((np.cos(np.arange(ANGLE_BINS) * BIN), np.sin(np.arange(ANGLE_BINS) * BIN)))

ANGLE_MARGIN = 2
"""The angle goes round: so many bins of the other end let peaks at the seam be seen whole."""

PEAK_REACH = (2, 1)
"""A peak is the highest within so many bins of angle and offset to either side."""

OFFSET_BIN = 3.0
"""Width of a bin of the accumulator [px at the reference width]."""

VOTE_SPREAD = 2
"""Bins to either side of the gradient's direction that it votes for."""

MOST_LINES = 24
MOST_CABLES = 8

SHARED_SPREAD = 0.5
"""Share of the spread of all votes in what the votes at one angle are judged by."""


class LinePairProposer:
    """Propose cables where two lines of opposite contrast are nearly parallel.

    Parameters
    ----------
    limits : PairLimits
        Widths and skews of the cables that are proposed.
    """

    def __init__(self, limits: PairLimits = DEFAULT_LIMITS) -> None:
        self._limits = limits

    def propose(self, image: WorkingImage) -> FloatArray:
        """Return d, alpha, w, beta of cables in the frame [px, rad], best first, shape (K, 4)."""
        offset_bin, middle = accumulator_layout(image)
        limits = self._limits.scaled(image.scale)
        angles, offsets, supports = strongest_lines(
            accumulated_votes(image), offset_bin, middle, MOST_LINES
        )
        width, height = image.size
        poses, scores = plausible_pairs(
            angles, offsets, supports, limits, (float(width), float(height))
        )
        best = np.argsort(-scores, kind="stable")[:MOST_CABLES]
        scale = 1.0 / image.reduction
        return np.asarray(poses[best] * np.array([scale, 1.0, scale, 1.0]))


class _Accumulator(NamedTuple):
    """Votes by normal and offset; `middle` is the number of the bin of offset zero."""

    votes: FloatArray
    bins_per_pixel: float
    middle: int


def accumulator_layout(image: WorkingImage) -> tuple[float, int]:
    """Return the width of a bin of offsets [px], and the number of the bin of offset zero."""
    offset_bin = max(OFFSET_BIN * image.scale, 1.0)
    return offset_bin, int(np.hypot(*image.size) / 2 / offset_bin) + 2


def accumulated_votes(image: WorkingImage) -> FloatArray:
    """Return the votes of a frame's scan lines for normals and offsets.

    Returns
    -------
    FloatArray
        Shape (ANGLE_BINS + 2 ANGLE_MARGIN, 2 middle + 1); the first and last rows repeat the other
        end.
    """
    offset_bin, middle = accumulator_layout(image)
    votes = np.zeros((ANGLE_BINS + 2 * ANGLE_MARGIN, 2 * middle + 1))
    rows, columns = image.scanned.rows, image.scanned.columns
    accumulator = _Accumulator(votes, 1.0 / offset_bin, middle)
    _vote(rows.gradients, rows.places, False, accumulator)
    _vote(columns.gradients, columns.places, True, accumulator)
    _wrap_margins(votes)
    return votes


@compiled
def _vote(gradients: Image, places: FloatArray, turned: bool, accumulator: _Accumulator) -> None:
    """Let the ridges of the gradient along scan lines vote; `turned` scan lines are columns."""
    length = gradients.shape[1]
    for line in range(len(places)):
        values = gradients[line]
        before = np.float32(0.0)
        here = values[0, 0] * values[0, 0] + values[0, 1] * values[0, 1]
        for place in range(1, length):
            if place + 1 == length:
                break
            before, here = here, values[place, 0] ** 2 + values[place, 1] ** 2
            if not (here > STRONG * STRONG and here >= before):
                continue
            along, across = values[place, 0], values[place, 1]
            after = values[place + 1, 0] ** 2 + values[place + 1, 1] ** 2
            if here > after and abs(along) >= abs(across):
                u, v = place - (length - 1) / 2, places[line]
                weight = min(math.sqrt(here), VOTE_CAP)
                if turned:
                    _cast(v, u, (float(across), float(along)), weight, accumulator)
                else:
                    _cast(u, v, (float(along), float(across)), weight, accumulator)


@compiled_inside
def _cast(
    x: float,
    y: float,
    gradient: tuple[float, float],
    weight: float,
    accumulator: _Accumulator,
) -> None:
    """Vote near the gradient's direction (where it gets brighter) for lines through a point."""
    nearest = int(np.rint(math.atan2(gradient[1], gradient[0]) / BIN))
    for angle in range(nearest - VOTE_SPREAD, nearest + VOTE_SPREAD + 1):
        within = angle + ANGLE_BINS if angle < 0 else angle
        offset = x * DIRECTIONS[0, within] + y * DIRECTIONS[1, within]
        column = int(np.rint(offset * accumulator.bins_per_pixel)) + accumulator.middle
        accumulator.votes[within + ANGLE_MARGIN, column] += weight


@compiled
def _wrap_margins(votes: FloatArray) -> None:
    for step in range(ANGLE_MARGIN):
        for column in range(votes.shape[1]):
            votes[step, column] = votes[step + ANGLE_BINS, column]
            votes[step + ANGLE_BINS + ANGLE_MARGIN, column] = votes[step + ANGLE_MARGIN, column]


@compiled
def strongest_lines(
    votes: FloatArray, offset_bin: float, middle: int, most: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return angles, offsets and clearness of the highest peaks, best first.

    The votes for a line are judged by those for the others at its angle: among ripples, one more
    line along them is nothing. Angle and offset are those of the vertex between the bins.

    Parameters
    ----------
    votes : FloatArray
        See `accumulated_votes`.
    offset_bin, middle : float, int
        See `accumulator_layout`.
    most : int
        Number of lines at most.
    """
    smooth = clearness_of(smoothed(votes))
    columns = smooth.shape[1]
    peaks = _peaks(smooth, highest_near(smooth))
    heights = np.empty(len(peaks), np.float32)
    for index in range(len(peaks)):
        heights[index] = smooth[peaks[index] // columns, peaks[index] % columns]
    order = highest_first(heights, most)
    angles, offsets, supports = np.empty(len(order)), np.empty(len(order)), np.empty(len(order))
    for rank in range(len(order)):
        peak = peaks[order[rank]]
        row, column = peak // columns, peak % columns
        here = smooth[row, column]
        turn, shift = _vertex(smooth[row - 1, column], here, smooth[row + 1, column]), 0.0
        if 0 < column < columns - 1:
            shift = _vertex(smooth[row, column - 1], here, smooth[row, column + 1])
        angles[rank] = (row - ANGLE_MARGIN + turn) * BIN
        offsets[rank] = (column + shift - middle) * offset_bin
        supports[rank] = here
    return angles, offsets, supports


@compiled_inside
def _vertex(before: float, here: float, after: float) -> float:
    """Return where the parabola through three values is highest, from -0.5 to 0.5."""
    bend = 2.0 * here - before - after
    if bend <= 0.0:
        return 0.0
    return float(min(max(0.5 * (after - before) / bend, -0.5), 0.5))


@compiled_part
def clearness_of(smooth: Image) -> Image:
    """Return how far votes stand above the others at their angle, in spreads; at least 0."""
    clear = np.empty_like(smooth)
    shared = SHARED_SPREAD * _mean_and_spread(smooth.reshape(-1))[1]
    for row in range(len(smooth)):
        mean, spread = _mean_and_spread(smooth[row])
        for column in range(smooth.shape[1]):
            excess = (smooth[row, column] - mean) / (spread + shared + 1e-6)
            clear[row, column] = max(excess, 0.0)
    return clear


@compiled_loop
def _mean_and_spread(values: Image) -> tuple[float, float]:
    """Return the mean of numbers (N,) and their standard deviation."""
    total = np.float32(0.0)
    for value in values:
        total += value
    mean = float(total / len(values))
    squares = 0.0
    for value in values:
        squares += (value - mean) * (value - mean)
    return mean, math.sqrt(squares / len(values))


@compiled_part
def smoothed(votes: FloatArray) -> Image:
    """Weigh each cell and its eight neighbours by 1/4, 1/2, 1/4 each way; mirrored at the ends."""
    height, width = votes.shape
    cells = np.empty(width + 2, np.float32)
    along = np.empty((height, width), np.float32)
    smooth = np.empty((height, width), np.float32)
    for row in range(height):
        for column in range(width):
            cells[column + 1] = votes[row, column]
        cells[0], cells[width + 1] = cells[2], cells[width - 1]
        _fold(cells[:-2], cells[1:-1], cells[2:], along[row])
    for row in range(height):
        below = row + 1 if row + 1 < height else height - 2
        _fold(along[abs(row - 1)], along[row], along[below], smooth[row])
    return smooth


@compiled_fast_loop
def _fold(before: Image, here: Image, after: Image, result: Image) -> None:
    half, quarter = np.float32(0.5), np.float32(0.25)
    for x in range(len(result)):
        result[x] = half * here[x] + quarter * (before[x] + after[x])


@compiled_part
def highest_near(smooth: Image) -> Image:
    """Return the highest value within `PEAK_REACH` of each cell, but for rows at the margins."""
    height = len(smooth)
    along = smooth.copy()
    for row in range(height):
        for step in range(1, PEAK_REACH[1] + 1):
            _raise_to(along[row, :-step], smooth[row, step:])
            _raise_to(along[row, step:], smooth[row, :-step])
    highest = along.copy()
    for row in range(PEAK_REACH[0], height - PEAK_REACH[0]):
        for step in range(1, PEAK_REACH[0] + 1):
            _raise_to(highest[row], along[row - step])
            _raise_to(highest[row], along[row + step])
    return highest


@compiled_fast_loop
def _raise_to(values: Image, others: Image) -> None:
    for x in range(len(values)):
        values[x] = max(values[x], others[x])


@compiled_part
def _peaks(heights: Image, highest: Image) -> IndexArray:
    """Return the flat indices (P,) of the cells that are as high as the highest near them."""
    height, width = heights.shape
    count = np.int64(0)
    peaks = np.empty(height * width + 1, np.int64)
    for row in range(ANGLE_MARGIN, height - ANGLE_MARGIN):
        for column in range(width):
            # Without a branch, which no processor could predict: what is no peak is written over.
            peaks[count] = row * width + column
            value = heights[row, column]
            count += np.int64(value >= highest[row, column]) & np.int64(value > 0.0)
    return peaks[:count]


@compiled_part
def highest_first(values: FloatArray | Image, most: int) -> IndexArray:
    """Return the indices of the highest values; of equal ones the first comes first."""
    count = min(most, len(values))
    order = np.empty(count, np.int64)
    taken = np.zeros(len(values), np.bool_)
    for rank in range(count):
        best = -1
        for index in range(len(values)):
            if not taken[index] and (best < 0 or values[index] > values[best]):
                best = index
        order[rank] = best
        taken[best] = True
    return order
