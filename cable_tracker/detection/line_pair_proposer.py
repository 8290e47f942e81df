"""Line pairs of a whole frame, fast enough for every frame of a tracker.

A coarse Hough transform over the gradients that the tracker has worked out anyway. Each strong
gradient votes near its own direction over the full turn, so that the two borders of a cable have
opposite normals. What comes out is a proposal: coarse, often wrong, seldom without the cable.

The constants were chosen on simulated dives of the seeds 200 to 203.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.measure.scanned_gradients import ScanLines
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.compilation import (
    compiled,
    compiled_fast_loop,
    compiled_inside,
    compiled_loop,
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

PEAK_WINDOW = np.ones((2 * ANGLE_MARGIN + 1, 3), np.uint8)
"""A peak is the highest among these bins of angle and offset about it."""

OFFSET_BIN = 3.0
"""Width of a bin of the accumulator [px at the reference width]."""

VOTE_SPREAD = 2
"""Bins to either side of the gradient's direction that it votes for."""

MOST_LINES = 24
MOST_CABLES = 8

SHARED_SPREAD = 0.5
"""Share of the spread of all votes in what the votes at one angle are judged by."""

LEAST_HEIGHT = np.float32(1e-12)
"""Lower cells are no peaks: what does not stand above the others at its angle is 0."""

NO_SPREAD = np.float32(1e-6)
"""Added to a spread: a frame without strong gradients has none."""


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

    votes: Image
    bins_per_pixel: float
    middle: int


def accumulator_layout(image: WorkingImage) -> tuple[float, int]:
    """Return the width of a bin of offsets [px], and the number of the bin of offset zero."""
    offset_bin = max(OFFSET_BIN * image.scale, 1.0)
    return offset_bin, int(np.hypot(*image.size) / 2 / offset_bin) + 2


def accumulated_votes(image: WorkingImage) -> Image:
    """Return the votes of a frame's scan lines for normals and offsets.

    Returns
    -------
    Image
        float32, shape (ANGLE_BINS + 2 ANGLE_MARGIN, 2 middle + 1); the first and last rows repeat
        the other end.
    """
    offset_bin, middle = accumulator_layout(image)
    votes = np.zeros((ANGLE_BINS + 2 * ANGLE_MARGIN, 2 * middle + 1), np.float32)
    rows, columns = image.scanned.rows, image.scanned.columns
    accumulator = _Accumulator(votes, 1.0 / offset_bin, middle)
    _vote_of_both(rows, columns, accumulator)
    votes[:ANGLE_MARGIN] = votes[ANGLE_BINS : ANGLE_BINS + ANGLE_MARGIN]
    votes[-ANGLE_MARGIN:] = votes[ANGLE_MARGIN : 2 * ANGLE_MARGIN]
    return votes


@compiled
def _vote_of_both(rows: ScanLines, columns: ScanLines, accumulator: _Accumulator) -> None:
    _vote(rows, False, accumulator)
    _vote(columns, True, accumulator)


@compiled_loop
def _vote(lines: ScanLines, turned: bool, accumulator: _Accumulator) -> None:
    """Let the ridges of the gradient along scan lines vote; `turned` scan lines are columns."""
    places, length = lines.places, lines.gradients.shape[1]
    for line in range(len(places)):
        values = lines.gradients[line]
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


def strongest_lines(
    votes: Image, offset_bin: float, middle: int, most: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return angles, offsets and clearness of the highest peaks, best first.

    The votes for a line are judged by those for the others at its angle: among ripples, one more
    line along them is nothing. Angle and offset are those of the vertex between the bins.

    Parameters
    ----------
    votes : Image
        See `accumulated_votes`.
    offset_bin, middle : float, int
        See `accumulator_layout`.
    most : int
        Number of lines at most.
    """
    smooth = np.asarray(cv2.GaussianBlur(np.asarray(votes, np.float32), (3, 3), 0))
    clear = clearness_of(smooth)
    peaks = _peaks(clear, np.asarray(cv2.dilate(clear, PEAK_WINDOW)))
    rows, columns, heights = peaks[:, np.argsort(-peaks[2], kind="stable")[:most]]
    return (rows - ANGLE_MARGIN) * BIN, (columns - middle) * offset_bin, heights


@compiled
def clearness_of(votes: Image) -> Image:
    """Return how far votes stand above the others at their angle, in spreads; at least 0."""
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


@compiled
def _peaks(clear: Image, highest: Image) -> FloatArray:
    """Return row, column and height of the cells that are the highest near them, shape (3, P).

    Row and column are those of the vertices of parabolas through a cell and its neighbours.
    """
    rows, columns = clear.shape
    places, count = np.empty(rows * columns, np.int64), 0
    for row in range(ANGLE_MARGIN, rows - ANGLE_MARGIN):
        for column in range(columns):
            if clear[row, column] >= max(highest[row, column], LEAST_HEIGHT):
                places[count] = row * columns + column
                count += 1
    peaks = np.empty((3, count))
    for index in range(count):
        row, column = places[index] // columns, places[index] % columns
        here = clear[row, column]
        left, right = clear[row, max(column - 1, 0)], clear[row, min(column + 1, columns - 1)]
        peaks[0, index] = row + _vertex(clear[row - 1, column], here, clear[row + 1, column])
        peaks[1, index] = column + _vertex(left, here, right)
        peaks[2, index] = here
    return peaks


@compiled_inside
def _vertex(before: float, here: float, after: float) -> float:
    """Return where the parabola through three values is highest, from -0.5 to 0.5."""
    bend = 2.0 * here - before - after
    if bend <= 0.0:
        return 0.0
    return min(max(0.5 * (after - before) / bend, -0.5), 0.5)
