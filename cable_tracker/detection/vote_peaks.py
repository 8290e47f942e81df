"""The clearest lines among votes for angles and offsets.

The angles go over the full turn, so that the two borders of a cable have opposite normals.
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.compilation import (
    compiled,
    compiled_fast_loop,
    compiled_inside,
    compiled_part,
)

ANGLE_BINS = 120
"""Bins of an accumulator over a full turn."""

BIN = 2.0 * math.pi / ANGLE_BINS
DIRECTIONS = np.stack((np.cos(np.arange(ANGLE_BINS) * BIN), np.sin(np.arange(ANGLE_BINS) * BIN)))

ANGLE_MARGIN = 2
"""Bins of angle that are repeated beyond either end: angles are periodic, and a peak may lie across
the seam. A peak is the highest among as many bins of angle to either side, and the bins of offset
next to it."""

SHARED_SPREAD = 0.5
"""Share of the spread of all votes in what the votes at one angle are judged by."""

LEAST_HEIGHT = np.float32(1e-12)
"""Lower cells are no peaks: what does not stand above the others at its angle is 0."""

NO_SPREAD = np.float32(1e-6)
"""Added to a spread: a frame without strong gradients has none."""


def strongest_lines(
    votes: Image, offset_bin: float, most: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return angles, offsets and clearness of the highest peaks, best first.

    The votes for a line are judged by those for the others at its angle: among ripples, one more
    line along them is nothing. Angle and offset are those of the vertex between the bins.

    Parameters
    ----------
    votes : Image
        float32, shape (ANGLE_BINS, 2 n + 1); offset zero is in the middle.
    offset_bin : float
        Width of a bin of offsets [px].
    most : int
        Number of lines at most.
    """
    around = np.concatenate((votes[-ANGLE_MARGIN:], votes, votes[:ANGLE_MARGIN]))
    smooth = np.asarray(cv2.GaussianBlur(np.asarray(around, np.float32), (3, 3), 0))
    return _strongest_lines(smooth, offset_bin, most)


@compiled
def _strongest_lines(
    votes: Image, offset_bin: float, most: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the result of `strongest_lines`, from blurred votes with the ends repeated."""
    clear = clearness_of(votes)
    highest = highest_about(clear)
    rows, columns = clear.shape
    middle = columns // 2
    heights, cells, count = np.empty(most), np.empty(most, np.int64), 0
    for row in range(ANGLE_MARGIN, rows - ANGLE_MARGIN):
        for column in range(columns):
            here = clear[row, column]
            if here < max(highest[row, column], LEAST_HEIGHT):
                continue
            if count < most:
                count += 1
            elif here <= heights[most - 1]:
                continue
            place = count - 1
            while place > 0 and heights[place - 1] < here:
                heights[place], cells[place] = heights[place - 1], cells[place - 1]
                place -= 1
            heights[place], cells[place] = here, row * columns + column
    angles, offsets = np.empty(count), np.empty(count)
    for index in range(count):
        row, column = cells[index] // columns, cells[index] % columns
        here = clear[row, column]
        left, right = clear[row, max(column - 1, 0)], clear[row, min(column + 1, columns - 1)]
        above, below = clear[row - 1, column], clear[row + 1, column]
        angles[index] = (row + _vertex(above, here, below) - ANGLE_MARGIN) * BIN
        offsets[index] = (column + _vertex(left, here, right) - middle) * offset_bin
    return angles, offsets, heights[:count]


@compiled_part
def highest_about(clear: Image) -> Image:
    """Return the local maximum about each cell, see `ANGLE_MARGIN`; end rows are not set."""
    rows, columns = clear.shape
    beside, highest = np.empty((rows, columns), np.float32), np.empty((rows, columns), np.float32)
    for row in range(rows):
        values, last = clear[row], columns - 1
        for column in range(1, last):
            either = max(values[column - 1], values[column + 1])
            beside[row, column] = max(values[column], either)
        beside[row, 0] = max(values[0], values[1])
        beside[row, last] = max(values[last - 1], values[last])
    for row in range(ANGLE_MARGIN, rows - ANGLE_MARGIN):
        for column in range(columns):
            highest[row, column] = beside[row, column]
        for step in range(-ANGLE_MARGIN, ANGLE_MARGIN + 1):
            for column in range(columns):
                highest[row, column] = max(highest[row, column], beside[row + step, column])
    return highest


@compiled_part
def clearness_of(votes: Image) -> Image:
    """Return the excess of votes over the mean at their angle, in spreads; at least 0."""
    rows, columns = votes.shape
    clear = np.empty((rows, columns), np.float32)
    means, spreads, sums, squares = np.empty(rows), np.empty(rows), 0.0, 0.0
    for row in range(rows):
        mean, variance = _moments(votes[row])
        means[row] = mean
        spreads[row] = math.sqrt(variance)
        sums += mean
        squares += variance + mean * mean
    # The mean of the variances and the variance of the means.
    of_all = max(squares / rows - (sums / rows) ** 2, 0.0)
    for row in range(rows):
        spread = spreads[row] + SHARED_SPREAD * math.sqrt(of_all) + NO_SPREAD
        for column in range(columns):
            clear[row, column] = max((votes[row, column] - means[row]) / spread, 0.0)
    return clear


@compiled_fast_loop
def _moments(values: Image) -> tuple[float, float]:
    """Return mean and variance of values (N,)."""
    total, squares = np.float32(0.0), np.float32(0.0)
    for index in range(len(values)):
        total += values[index]
    mean = total / np.float32(len(values))
    for index in range(len(values)):
        deviation = values[index] - mean
        squares += deviation * deviation
    return float(mean), float(squares) / len(values)


@compiled_inside
def _vertex(before: float, here: float, after: float) -> float:
    """Return the vertex of the parabola through three values, from -0.5 to 0.5 [steps]."""
    bend = 2.0 * here - before - after
    if bend <= 0.0:
        return 0.0
    return min(max(0.5 * (after - before) / bend, -0.5), 0.5)
