"""See `cable_tracker.cable.measure.likelihood_ratio`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.measure.likelihood_ratio import (
    BEHIND,
    FARTHEST_BEHIND,
    FARTHEST_MIDDLE,
    NEAREST,
    OUTSIDE,
    SMALLEST_RESPONSE,
    BorderLikelihoodRatio,
    CableEvidence,
)
from cable_tracker.cable.measure.response_table import (
    COARSE,
    CONTRAST_BINS,
    CONTRAST_LIMIT,
    RESPONSE_BINS,
    RESPONSE_LIMIT,
    SLOPE_BINS,
    SLOPE_LIMIT,
    ResponseTable,
)
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import compiled, compiled_inside

EDGE_FACTOR = np.float32(RESPONSE_BINS / (2 * RESPONSE_LIMIT))
SLOPE_FACTOR = np.float32(SLOPE_BINS / SLOPE_LIMIT)
CONTRAST_FACTOR = np.float32(CONTRAST_BINS / (2 * CONTRAST_LIMIT))
RESPONSE_MIDDLE, CONTRAST_MIDDLE = np.float32(RESPONSE_LIMIT), np.float32(CONTRAST_LIMIT)
DOUBT = np.float32(SMALLEST_RESPONSE)


class RatioArrays(NamedTuple):
    """The fields of `CableEvidence`."""

    log_ratios: FloatArray
    weaker_borders: FloatArray
    seen: FloatArray


class Look(NamedTuple):
    """What the likelihood ratio of a frame is worked out from; rows come before columns."""

    gradients: tuple[Image, Image]
    smooth: tuple[Image, Image]
    places: tuple[FloatArray, FloatArray]
    reduction: float
    scale: float
    tables: tuple[Image, Image]
    tempering: float
    missing: float
    expected: float


class CompiledLikelihoodRatio(BorderLikelihoodRatio):
    """The twin of `BorderLikelihoodRatio`."""

    def __init__(self, parameters: TrackerParameters, table: ResponseTable | None = None) -> None:
        super().__init__(parameters, table)
        self._tables = (self._table.edges_of_both, self._table.contrasts_of_both)

    def measure(self, states: FloatArray, image: WorkingImage) -> CableEvidence:
        """Measure cables, shape (N, 4) or more columns."""
        count = len(states)
        results = RatioArrays(np.empty((count, 2)), np.empty((count, 2)), np.empty(count))
        measure_into(states, 0, count, self.look(image), results)
        return CableEvidence(*results)

    def look(self, image: WorkingImage) -> Look:
        """Return what compiled loops need to know of a frame."""
        rows, columns = image.scanned.rows, image.scanned.columns
        return Look(
            (rows.gradients, columns.gradients),
            (rows.smooth, columns.smooth),
            (rows.places, columns.places),
            image.reduction,
            image.scale,
            self._tables,
            self._tempering_in(image),
            self._missing,
            image.size[1] / image.line_spacing,
        )


@compiled
def measure_into(
    states: FloatArray, start: int, stop: int, look: Look, results: RatioArrays
) -> None:
    """Fill in the results for the states from `start` to `stop`."""
    gradients, smooth, places = look.gradients, look.smooth, look.places
    reduction, scale, tables = look.reduction, look.scale, look.tables
    tempering, missing, expected = look.tempering, look.missing, look.expected
    log_ratios, weaker, seen = results.log_ratios, results.weaker_borders, results.seen
    for cable in range(start, stop):
        distance, angle = states[cable, 0], states[cable, 1]
        half_width, skew = 0.5 * states[cable, 2], states[cable, 3]
        cos_skew = math.cos(skew)
        width = abs(2.0 * half_width * cos_skew) * reduction
        depths = (
            OUTSIDE * scale,
            min(max(BEHIND * width, NEAREST * scale), FARTHEST_BEHIND * scale),
            min(max(0.5 * width, NEAREST * scale), FARTHEST_MIDDLE * scale),
        )
        log_ratios[cable, 0], log_ratios[cable, 1] = 0.0, 0.0
        weaker[cable, 0], weaker[cable, 1] = np.inf, np.inf
        seen[cable] = np.inf
        for side in (-1.0, 1.0):
            normal = angle + side * skew
            offset = (distance + side * half_width) * cos_skew * reduction
            cos, sin = math.cos(normal), math.sin(normal)
            if abs(cos) >= abs(sin):
                bright, dark, length = _measure_border(
                    gradients[0],
                    smooth[0],
                    places[0],
                    cos,
                    sin,
                    offset,
                    -side,
                    depths,
                    scale,
                    tables,
                )
            else:
                bright, dark, length = _measure_border(
                    gradients[1],
                    smooth[1],
                    places[1],
                    sin,
                    cos,
                    offset,
                    -side,
                    depths,
                    scale,
                    tables,
                )
            lacking = missing * max(expected - length, 0.0)
            whole = max(length, expected)
            log_ratios[cable, 0] += tempering * (bright + lacking)
            log_ratios[cable, 1] += tempering * (dark + lacking)
            weaker[cable, 0] = min(weaker[cable, 0], (bright + lacking) / whole)
            weaker[cable, 1] = min(weaker[cable, 1], (dark + lacking) / whole)
            seen[cable] = min(seen[cable], length)


@compiled_inside
def _measure_border(
    gradients: Image,
    smooth: Image,
    places: FloatArray,
    along: float,
    across: float,
    offset: float,
    inward: float,
    depths: tuple[float, float, float],
    scale: float,
    tables: tuple[Image, Image],
) -> tuple[float, float, float]:
    """Return the summed ratios of a bright and of a dark border, and its length in view."""
    edges, contrasts = tables
    last = float(smooth.shape[1] - 1)
    middle = last / 2
    # A picture may be one pixel high.
    last_left = np.uint64(max(smooth.shape[1] - 2, 0))
    neighbour = np.uint64(min(smooth.shape[1] - 1, 1))
    stretch = inward / along
    # Rounds to the nearest place.
    outside, behind, deep = (
        0.5 - depths[0] * stretch,
        0.5 + depths[1] * stretch,
        0.5 + depths[2] * stretch,
    )
    response_along, response_across = np.float32(inward * along), np.float32(inward * across)
    slope_factor = np.float32(scale / along)
    start, step = offset / along, -across / along
    bright, dark = np.float32(0.0), np.float32(0.0)
    count = 0
    for number in range(len(places)):
        line = np.uint64(number)
        place = start + step * places[line]
        # Written so that a place that is no number is outside.
        if not abs(place) <= middle:
            continue
        count += 1
        position = place + middle
        left = min(_floor(position), last_left)
        share = np.float32(position - left)
        right = left + neighbour
        gradient_along = _between(gradients, line, left, right, 0, share)
        gradient_across = _between(gradients, line, left, right, 1, share)
        response = response_along * gradient_along + response_across * gradient_across
        slope = slope_factor * _between(gradients, line, left, right, 2, share)
        without = _level_at(smooth, line, position + outside, last)
        contrast = _agreed(
            _level_at(smooth, line, position + behind, last) - without,
            _level_at(smooth, line, position + deep, last) - without,
        )
        row = _bin(response, RESPONSE_MIDDLE, EDGE_FACTOR, RESPONSE_BINS)
        column = _bin(
            abs(slope) / (abs(response) + DOUBT), np.float32(0.0), SLOPE_FACTOR, SLOPE_BINS
        )
        cell = _bin(contrast, CONTRAST_MIDDLE, CONTRAST_FACTOR, CONTRAST_BINS)
        coarse = row // np.uint64(COARSE)
        bright += edges[row, column, 0] + contrasts[coarse, cell, 0]
        dark += edges[row, column, 1] + contrasts[coarse, cell, 1]
    length = 1.0 / abs(along)
    return float(bright) * length, float(dark) * length, count * length


@compiled_inside
def _between(
    gradients: Image,
    line: np.uint64,
    left: np.uint64,
    right: np.uint64,
    channel: int,
    share: np.float32,
) -> np.float32:
    """Interpolate a channel between two neighbouring places of a line."""
    here, there = gradients[line, left, channel], gradients[line, right, channel]
    value: np.float32 = here + (there - here) * share
    return value


@compiled_inside
def _level_at(smooth: Image, line: np.uint64, position: float, last: float) -> np.float32:
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
def _agreed(behind: np.float32, middle: np.float32) -> np.float32:
    # Without a branch, which nobody could predict: whichever of the two is zero adds nothing.
    nothing = np.float32(0.0)
    return max(min(behind, middle), nothing) + min(max(behind, middle), nothing)


@compiled_inside
def _bin(value: np.float32, shift: np.float32, factor: np.float32, count: int) -> np.uint64:
    scaled = (value + shift) * factor
    return np.uint64(np.int32(min(max(scaled, np.float32(0.0)), np.float32(count - 1))))
