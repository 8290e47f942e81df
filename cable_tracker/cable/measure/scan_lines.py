"""Borders measured where they cross some rows and columns of the picture.

The thesis looks at points along every border of every particle, with a filter of its own across
each. Here the same filter runs once along every twentieth row, and a border is looked up where it
crosses the row; one that is nearer to horizontal than to vertical, where it crosses every twentieth
column. The answer to a step does not depend on the slant under which the row crosses it. The
crossings of a slanted border lie 1 / cos further apart, so its sum is multiplied by that, and means
the same as that of points at equal distances along the border.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image, IndexArray
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.geometry import Borders, project_borders
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH, TrackerParameters
from cable_tracker.cable.thesis.observation import (
    BorderResponses,
    log_weights_of_responses,
    scaled_filter,
)

CABLES_PER_CELL = 1.5
"""A table of sums pays for at least so many cables per entry."""

TABLE_COUNT = 2000
"""Fewer cables are looked up one by one."""

MOST_ENTRIES = 1e6
"""More than any table has along one side."""

GRID_COLUMNS, GRID_ROWS = 24, 18
"""Places at which the frame's own scale is measured: half along rows, half along columns."""


@dataclass(frozen=True, slots=True, eq=False)
class ScanPlan:
    """Which rows, columns and single pixels of a working picture are filtered.

    Attributes
    ----------
    rows, columns : IndexArray
        Indices of the lines, shapes (R,), (C,).
    heights : FloatArray
        y of the rows above the image centre [working px], shape (R,).
    places : FloatArray
        x of the columns [working px], shape (C,).
    grid : IndexArray
        Row and column of the places for the frame's scale, shape (G, 2). Even ones are filtered
        along their row, odd ones along their column.
    """

    rows: IndexArray
    columns: IndexArray
    heights: FloatArray
    places: FloatArray
    grid: IndexArray


@lru_cache(maxsize=16)
def scan_plan(size: tuple[int, int], sample_spacing: float) -> ScanPlan:
    """Return the plan for working pictures of a size (width, height).

    `sample_spacing` is that of the parameters [px at the reference width].
    """
    width, height = size
    # Lines closer than a pixel would be the same line twice.
    spacing = max(sample_spacing * width / REFERENCE_WIDTH, 1.0)
    rows, columns = (
        _lines(height, spacing)[::-1].copy(),
        _lines(width, spacing),
    )
    return ScanPlan(
        rows=rows,
        columns=columns,
        heights=(height - 1) / 2 - rows.astype(np.float64),
        places=columns.astype(np.float64) - (width - 1) / 2,
        grid=_grid(width, height),
    )


def _lines(length: int, spacing: float) -> IndexArray:
    reach = int((length - 1) / 2 / spacing)
    along = (length - 1) / 2 + np.arange(-reach, reach + 1) * spacing
    # Where the lines lie as far apart as pixels, rounding could repeat one.
    return np.unique(np.clip(np.floor(along + 0.5), 0, length - 1).astype(np.int64))


def _grid(width: int, height: int) -> IndexArray:
    rows = ((np.arange(GRID_ROWS) + 0.5) / GRID_ROWS * height).astype(np.int64)
    columns = ((np.arange(GRID_COLUMNS) + 0.5) / GRID_COLUMNS * width).astype(np.int64)
    # Neighbours in a row differ in their direction, and so do neighbours in a column.
    places = [
        (row, columns[k ^ (number % 2)])
        for number, row in enumerate(rows)
        for k in range(GRID_COLUMNS)
    ]
    return np.array(places, dtype=np.int64)


def filter_along(lines: Image, half: FloatArray) -> Image:
    """Apply an odd filter along the last axis of float32 lines (L, n).

    `half` are its taps at 1, 2, .. px [1/px]. The outermost pixels go on beyond the ends.
    """
    reach, length = len(half), lines.shape[1]
    padded = np.pad(lines, ((0, 0), (reach, reach)), mode="edge")
    answer = np.zeros_like(lines)
    for k in range(1, reach + 1):
        difference = padded[:, reach + k : reach + k + length] - padded[:, reach - k :][:, :length]
        answer += np.float32(half[k - 1]) * difference
    return answer


@dataclass(frozen=True, slots=True, eq=False)
class ScannedFrame:
    """The filter's answers along the lines of a plan.

    Attributes
    ----------
    along_rows, along_columns : Image
        Shapes (R, w) and (C, h), float32 [grey levels]. Positive where the picture brightens
        towards the right, and towards the bottom.
    """

    along_rows: Image
    along_columns: Image


class ScanLineObservation:
    """Sums of derivative-of-Gaussian responses where the borders cross scan lines.

    Parameters
    ----------
    parameters : TrackerParameters
        Filter, spacing, epsilon.
    """

    def __init__(self, parameters: TrackerParameters) -> None:
        self._parameters = parameters
        self._last: tuple[WorkingImage, ScannedFrame] | None = None

    def log_likelihoods(self, states: FloatArray, observation: WorkingImage) -> FloatArray:
        """Return the logarithm of each cable's weight, shape (N,), for states (N, 8)."""
        responses = self.measure(project_borders(states), observation)
        return log_weights_of_responses(responses, self._parameters.epsilon)

    def measure(self, borders: Borders, image: WorkingImage) -> BorderResponses:
        """Sum the answers where each border crosses the lines."""
        plan = scan_plan(image.size, self._parameters.sample_spacing)
        scanned = self._scan(image, plan)
        width, height = image.size
        offsets = borders.offsets * image.reduction
        cosines, sines = np.cos(borders.angles), np.sin(borders.angles)
        lying = np.abs(cosines) < np.abs(sines)
        along = np.where(lying, sines, cosines)
        # Right of the left edge for rows, below the upper edge for columns, where answers to a rise
        # towards the top are negative.
        first = np.where(
            lying, (height - 1) / 2 - offsets / along, (width - 1) / 2 + offsets / along
        )
        slope = np.where(lying, cosines, -sines) / along
        gain = np.where(lying, -1.0, 1.0) / along
        sums, counts = np.zeros(along.shape), np.zeros(along.shape)
        for family, lines, positions in (
            (~lying, scanned.along_rows, plan.heights),
            (lying, scanned.along_columns, plan.places),
        ):
            sums[family], counts[family] = _sum_crossings(
                lines, positions, first[family], slope[family]
            )
            if family.all() and len(family) > TABLE_COUNT:
                for side in range(2):
                    sums[:, side] = sum_by_table(
                        lines, positions, table_step(image.scale), first[:, side], slope[:, side]
                    )
        # As many points at equal distances along the border would have seen the same.
        return BorderResponses(sums * gain, counts * np.abs(gain))

    def scattered_responses(self, image: WorkingImage) -> FloatArray:
        """Return the filter's answers at places all over the frame [grey levels], shape (G,)."""
        rows, columns = scan_plan(image.size, self._parameters.sample_spacing).grid.T
        half = self.half_filter(image)
        pixels, reach = image.averaged, np.arange(1, len(half) + 1)
        height, width = pixels.shape
        around = np.where((np.arange(len(rows)) % 2 == 0)[:, None], reach, 0)
        right = np.minimum(columns[:, None] + around, width - 1)
        left = np.maximum(columns[:, None] - around, 0)
        below = np.minimum(rows[:, None] + reach - around, height - 1)
        above = np.maximum(rows[:, None] - reach + around, 0)
        # Differences first: a flat picture answers with zeros, not with rounding.
        responses: FloatArray = (pixels[below, right] - pixels[above, left]).astype(
            np.float64
        ) @ half
        return responses

    def half_filter(self, image: WorkingImage) -> FloatArray:
        """Return the filter's taps at 1, 2, .. working px."""
        taps = scaled_filter(self._parameters, image.scale)
        return taps[len(taps) // 2 + 1 :]

    def _scan(self, image: WorkingImage, plan: ScanPlan) -> ScannedFrame:
        if self._last is None or self._last[0] is not image:
            half, pixels = self.half_filter(image), image.averaged
            scanned = ScannedFrame(
                filter_along(pixels[plan.rows], half), filter_along(pixels[:, plan.columns].T, half)
            )
            self._last = (image, scanned)
        return self._last[1]


def _sum_crossings(
    lines: Image, positions: FloatArray, first: FloatArray, slope: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return sums and numbers of the crossings inside the picture, shape (B,) each."""
    last = lines.shape[1] - 1
    crossings = first.astype(np.float32)[:, None] + slope.astype(np.float32)[:, None] * (
        positions.astype(np.float32)
    )
    inside: BoolArray = (crossings >= 0) & (crossings <= last)
    bounded = np.clip(crossings, 0, last)
    before = np.minimum(bounded.astype(np.int64), last - 1)
    share = bounded - before.astype(np.float32)
    numbers = np.arange(len(lines))
    low, high = lines[numbers, before], lines[numbers, before + 1]
    answers = np.where(inside, low + share * (high - low), np.float32(0.0))
    return answers.sum(axis=1).astype(np.float64), inside.sum(axis=1).astype(np.float64)


def table_step(scale: float) -> float:
    """Return how far apart the entries of a table lie [working px]."""
    return 0.5 * max(scale, 1.0)


def sum_by_table(
    lines: Image, positions: FloatArray, step: float, first: FloatArray, slope: FloatArray
) -> FloatArray:
    """Return the sums of the answers for borders (N,) of one side, which may be very many.

    All of them lie close together, and each is given by two numbers: where it crosses the middle
    line, and its slope. So the sums are worked out once for every half pixel of the one, and for
    slopes that move the outermost crossings by a pixel, and borders are looked up between.

    Parameters
    ----------
    lines, positions : Image, FloatArray
        Answers along the lines (L, n), and where the lines lie (L,) [working px].
    step : float
        Distance between entries [working px].
    first, slope : FloatArray
        Shape (N,).
    """
    slope_step = 2.0 * step / max(abs(positions[0]), abs(positions[-1]), 1.0)
    first, slope = first.astype(np.float32), slope.astype(np.float32)
    firsts, slopes = _entries(first, step), _entries(slope, slope_step)
    if len(firsts) * len(slopes) > len(first) / CABLES_PER_CELL:
        return _sum_crossings(lines, positions, first, slope)[0]
    grid = np.meshgrid(slopes, firsts, indexing="ij")
    sums = _sum_crossings(lines, positions, grid[1].ravel(), grid[0].ravel())[0]
    table = sums.reshape(len(slopes), len(firsts))
    u, v = (first - firsts[0]) / step, (slope - slopes[0]) / slope_step
    i = np.clip(np.floor(u), 0, len(firsts) - 2).astype(np.int64)
    j = np.clip(np.floor(v), 0, len(slopes) - 2).astype(np.int64)
    upper = table[j, i] + (u - i) * (table[j, i + 1] - table[j, i])
    lower = table[j + 1, i] + (u - i) * (table[j + 1, i + 1] - table[j + 1, i])
    looked_up: FloatArray = upper + (v - j) * (lower - upper)
    return looked_up


def _entries(values: FloatArray, step: float) -> FloatArray:
    """Return multiples of a step from below the values to above them."""
    start = np.floor(values.min() / step)
    count = np.floor(values.max() / step - start) + 2.0
    # Where borders lie across the lines there is no end to them, and no table.
    entries: FloatArray = (start + np.arange(min(count, MOST_ENTRIES))) * step
    return entries
