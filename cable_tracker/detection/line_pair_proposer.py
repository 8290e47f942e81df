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
from cable_tracker.compilation import compiled, compiled_fast, compiled_inside
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

MOST_LINES = 16
MOST_CABLES = 6


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
        places = best_cables(
            angles, offsets, supports, (limits.narrowest, limits.widest), limits.most_skew
        )
        scale = 1.0 / image.reduction
        return np.asarray(places * np.array([scale, 1.0, scale, 1.0]))


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
        votes[step] = votes[step + ANGLE_BINS]
        votes[step + ANGLE_BINS + ANGLE_MARGIN] = votes[step + ANGLE_MARGIN]


@compiled
def strongest_lines(
    votes: FloatArray, offset_bin: float, middle: int, most: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return angles, offsets and smoothed votes of the highest peaks, best first.

    Parameters
    ----------
    votes : FloatArray
        See `accumulated_votes`.
    offset_bin, middle : float, int
        See `accumulator_layout`.
    most : int
        Number of lines at most.
    """
    smooth = smoothed(votes)
    inner = slice(ANGLE_MARGIN, ANGLE_MARGIN + ANGLE_BINS)
    columns = smooth.shape[1]
    cells = smooth[inner].reshape(-1)
    peaks = _peaks(cells, highest_near(smooth)[inner].reshape(-1))
    order = highest_first(cells[peaks], most)
    angles, offsets, supports = np.empty(len(order)), np.empty(len(order)), np.empty(len(order))
    for rank in range(len(order)):
        peak = peaks[order[rank]]
        angles[rank] = (peak // columns) * BIN
        offsets[rank] = (peak % columns - middle) * offset_bin
        supports[rank] = cells[peak]
    return angles, offsets, supports


@compiled
def smoothed(votes: FloatArray) -> Image:
    """Weigh each cell and its eight neighbours by 1/4, 1/2, 1/4 each way; mirrored at the ends."""
    height, width = votes.shape
    cells = np.empty(width + 2, np.float32)
    along = np.empty((height, width), np.float32)
    smooth = np.empty((height, width), np.float32)
    for row in range(height):
        cells[1:-1] = votes[row]
        cells[0], cells[width + 1] = cells[2], cells[width - 1]
        _fold(cells[:-2], cells[1:-1], cells[2:], along[row])
    for row in range(height):
        below = row + 1 if row + 1 < height else height - 2
        _fold(along[abs(row - 1)], along[row], along[below], smooth[row])
    return smooth


@compiled_fast
def _fold(before: Image, here: Image, after: Image, result: Image) -> None:
    half, quarter = np.float32(0.5), np.float32(0.25)
    for x in range(len(result)):
        result[x] = half * here[x] + quarter * (before[x] + after[x])


@compiled
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


@compiled_fast
def _raise_to(values: Image, others: Image) -> None:
    for x in range(len(values)):
        values[x] = max(values[x], others[x])


@compiled
def _peaks(heights: Image, highest: Image) -> IndexArray:
    """Return which cells (C,) are as high as the highest near them, shape (P,)."""
    count = 0
    peaks = np.empty(len(heights) + 1, np.int64)
    for cell in range(len(heights)):
        # Without a branch, which no processor could predict: what is no peak is written over.
        peaks[count] = cell
        count += int(heights[cell] >= highest[cell]) & int(heights[cell] > 0.0)
    return peaks[:count]


@compiled
def highest_first(values: FloatArray, most: int) -> IndexArray:
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


@compiled
def best_cables(
    angles: FloatArray,
    offsets: FloatArray,
    supports: FloatArray,
    widths: tuple[float, float],
    most_skew: float,
) -> FloatArray:
    """Return d, alpha, w, beta of the best pairs of lines, at most `MOST_CABLES`, shape (K, 4)."""
    places, scores = plausible_pairs(angles, offsets, supports, widths, most_skew)
    return places[highest_first(scores, MOST_CABLES)]
