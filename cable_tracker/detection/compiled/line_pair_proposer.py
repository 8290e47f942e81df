"""See `cable_tracker.detection.line_pair_proposer`."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.compiled.geometry import turn_sign, wrapped_angle
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.state import PLACES
from cable_tracker.compilation import compiled, compiled_fast, compiled_inside
from cable_tracker.detection.line_pair_proposer import (
    ANGLE_BINS,
    ANGLE_MARGIN,
    MOST_CABLES,
    MOST_LINES,
    MOST_SKEW,
    NARROWEST,
    NEIGHBOURHOOD,
    STRONG,
    VOTE_CAP,
    VOTE_SPREAD,
    WIDEST,
    accumulator_layout,
)

BIN = 2.0 * math.pi / ANGLE_BINS
REACH = (NEIGHBOURHOOD.shape[0] // 2, NEIGHBOURHOOD.shape[1] // 2)
DIRECTIONS = np.stack((np.cos(np.arange(ANGLE_BINS) * BIN), np.sin(np.arange(ANGLE_BINS) * BIN)))


class CompiledLinePairProposer:
    """The twin of `LinePairProposer`."""

    def propose(self, image: WorkingImage) -> FloatArray:
        """Return d, alpha, w, beta of cables in the frame [px, rad], best first, shape (K, 4)."""
        offset_bin, middle = accumulator_layout(image)
        votes = np.zeros((ANGLE_BINS + 2 * ANGLE_MARGIN, 2 * middle + 1))
        rows, columns = image.scanned.rows, image.scanned.columns
        _vote(rows.gradients, rows.places, False, 1.0 / offset_bin, middle, votes)
        _vote(columns.gradients, columns.places, True, 1.0 / offset_bin, middle, votes)
        _wrap_margins(votes)
        angles, offsets, supports = _strongest_lines(_smoothed(votes), offset_bin, middle)
        return _best_pairs(angles, offsets, supports, image.scale, 1.0 / image.reduction)


@compiled
def _vote(
    gradients: Image,
    places: FloatArray,
    turned: bool,
    bins_per_pixel: float,
    middle: int,
    votes: FloatArray,
) -> None:
    """Let the ridges along scan lines vote; `turned` scan lines are columns."""
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
                    _cast(v, u, float(across), float(along), weight, bins_per_pixel, middle, votes)
                else:
                    _cast(u, v, float(along), float(across), weight, bins_per_pixel, middle, votes)


@compiled_inside
def _cast(
    x: float,
    y: float,
    gradient_x: float,
    gradient_y: float,
    weight: float,
    bins_per_pixel: float,
    middle: int,
    votes: FloatArray,
) -> None:
    nearest = int(np.rint(math.atan2(gradient_y, gradient_x) / BIN))
    for angle in range(nearest - VOTE_SPREAD, nearest + VOTE_SPREAD + 1):
        within = angle + ANGLE_BINS if angle < 0 else angle
        offset = x * DIRECTIONS[0, within] + y * DIRECTIONS[1, within]
        column = int(np.rint(offset * bins_per_pixel)) + middle
        votes[within + ANGLE_MARGIN, column] += weight


@compiled
def _wrap_margins(votes: FloatArray) -> None:
    for step in range(ANGLE_MARGIN):
        votes[step] = votes[step + ANGLE_BINS]
        votes[step + ANGLE_BINS + ANGLE_MARGIN] = votes[step + ANGLE_MARGIN]


@compiled
def _smoothed(votes: FloatArray) -> Image:
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
def _highest(smooth: Image) -> Image:
    """Return the highest value in the neighbourhood of each cell, but for rows at the margins."""
    height = len(smooth)
    along = smooth.copy()
    for row in range(height):
        for step in range(1, REACH[1] + 1):
            _raise_to(along[row, :-step], smooth[row, step:])
            _raise_to(along[row, step:], smooth[row, :-step])
    highest = along.copy()
    for row in range(REACH[0], height - REACH[0]):
        for step in range(1, REACH[0] + 1):
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
        # Without a branch, which nobody could predict: what is no peak is written over.
        peaks[count] = cell
        count += int(heights[cell] >= highest[cell]) & int(heights[cell] > 0.0)
    return peaks[:count]


@compiled
def _strongest_lines(
    smooth: Image, offset_bin: float, middle: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return angles, offsets and votes of the highest peaks, best first."""
    inner = slice(ANGLE_MARGIN, ANGLE_MARGIN + ANGLE_BINS)
    columns = smooth.shape[1]
    cells = smooth[inner].reshape(-1)
    peaks = _peaks(cells, _highest(smooth)[inner].reshape(-1))
    order = _highest_first(cells[peaks], MOST_LINES)
    angles, offsets, supports = np.empty(len(order)), np.empty(len(order)), np.empty(len(order))
    for rank in range(len(order)):
        peak = peaks[order[rank]]
        angles[rank] = (peak // columns) * BIN
        offsets[rank] = (peak % columns - middle) * offset_bin
        supports[rank] = cells[peak]
    return angles, offsets, supports


@compiled
def _highest_first(values: FloatArray, most: int) -> IndexArray:
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
def _best_pairs(
    angles: FloatArray, offsets: FloatArray, supports: FloatArray, scale: float, enlargement: float
) -> FloatArray:
    count = len(angles)
    states = np.empty((count * (count - 1) // 2, PLACES))
    scores = np.empty(len(states))
    pair = 0
    for first in range(count):
        for second in range(first + 1, count):
            _cable_between(
                angles[first], offsets[first], angles[second], offsets[second], states[pair]
            )
            plausible = (
                NARROWEST * scale <= states[pair, 2] <= WIDEST * scale
                and abs(states[pair, 3]) <= MOST_SKEW
            )
            scores[pair] = supports[first] * supports[second] if plausible else -1.0
            pair += 1
    order = _highest_first(scores, MOST_CABLES)
    best = np.empty((len(order), PLACES))
    found = 0
    for index in order:
        if scores[index] > 0.0:
            best[found] = states[index]
            best[found, 0] *= enlargement
            best[found, 2] *= enlargement
            found += 1
    return best[:found]


@compiled
def _cable_between(
    angle: float, offset: float, other: float, other_offset: float, state: FloatArray
) -> None:
    """Fill in d, alpha, w, beta of the cable between two lines with opposite normals."""
    turned = -other_offset
    turn = (other + math.pi - angle + math.pi) % (2 * math.pi) - math.pi
    left, right = angle, angle + turn
    if offset > turned:
        left, right = right, left
    skew = (right - left) / 2
    cos_skew = math.cos(skew)
    middle = (left + right) / 2
    wrapped = wrapped_angle(middle)
    sign = turn_sign(middle, wrapped)
    state[0] = sign * (offset + turned) / (2 * cos_skew)
    state[1] = wrapped
    state[2] = abs(turned - offset) / cos_skew
    state[3] = sign * skew
