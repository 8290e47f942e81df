"""The loop of the fast contour: points beside the contour change sides where that costs less.

Table 1 of J. Ha (2008). Where the thesis is silent, it is our choice that: what lies beyond the
picture has no side; neither region is emptied; points that join a list during a scan wait for the
next one, or are looked at in the same (`flooding`).
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled, compiled_inside
from cable_tracker.contour.levels import EXTERIOR, INNER, INTERIOR, OUTER, Levels

FlatLevels: TypeAlias = NDArray[np.int8]
"""Levels with a margin of zeros about the picture, row after row."""

PointList: TypeAlias = NDArray[np.int32]
"""Places in them."""

FEWEST = 2
"""Points that either region keeps at least: with one, its mean would be divided by nothing."""


@compiled_inside
def _positive_neighbours(levels: FlatLevels, point: int, width: int) -> int:
    """Count the 8-neighbours outside; what lies beyond the picture counts for half."""
    doubled = 0
    for first in (point - width - 1, point - 1, point + width - 1):
        for neighbour in range(first, first + 3):
            if neighbour != point:
                doubled += (levels[neighbour] > 0) + (levels[neighbour] >= 0)
    return doubled // 2


@compiled_inside
def _join(
    levels: FlatLevels, point: int, deep: int, joined: int, points: PointList, count: int
) -> int:
    """Let a point of level `deep` join a list; return how long it is then."""
    if levels[point] == deep:
        levels[point] = joined
        points[count] = point
        return count + 1
    return count


@compiled_inside
def _drop_buried(
    levels: FlatLevels, width: int, points: PointList, count: int, own: int, deep: int
) -> int:
    """Drop the points of a list that no longer touch the other side; return how many remain."""
    kept = 0
    for index in range(count):
        point = points[index]
        if (
            levels[point - 1] * own < 0
            or levels[point + 1] * own < 0
            or levels[point - width] * own < 0
            or levels[point + width] * own < 0
        ):
            points[kept] = point
            kept += 1
        else:
            levels[point] = deep
    return kept


@compiled
def switch_points(
    data: NDArray[np.float32],
    levels: Levels,
    by_means: bool,
    regulariser: float,
    balance: float,
    most_iterations: int,
    flooding: bool,
    changes: FloatArray,
) -> tuple[int, bool, int, float, float, int]:
    """Let the contour evolve; `levels` is changed in place.

    Parameters
    ----------
    data : array
        Shape (H, W): intensities, or what speaks for the inside as a log-likelihood ratio.
    levels : Levels
        Start; afterwards the contour.
    by_means : bool
        Chan-Vese's energy of intensities, (15) and (16), or that of the log-likelihood ratio.
    regulariser, balance : float
        rho_1 and eps_N of (17) and (18).
    most_iterations : int
        Limit.
    flooding : bool
        Look at points that join a list during its scan in the same scan.
    changes : FloatArray
        Shape (K,): takes the changes of energy of the first K switches.

    Returns
    -------
    tuple
        Iterations done; whether nothing changed in the last; points inside; sum inside; sum
        outside; switches.
    """
    height, width = levels.shape
    stride = width + 2
    # A margin without a side saves asking whether a neighbour is within the picture.
    sides = np.zeros((height + 2) * stride, np.int8)
    values = np.empty((height + 2) * stride, np.float32)
    outer, inner = np.empty(height * width, np.int32), np.empty(height * width, np.int32)
    outer_count = inner_count = inside_count = switches = 0
    inside_sum = outside_sum = 0.0
    for row in range(height):
        for column in range(width):
            level = levels[row, column]
            value = data[row, column]
            point = (row + 1) * stride + column + 1
            sides[point] = level
            values[point] = value
            if level < 0:
                inside_count += 1
                inside_sum += value
                if level == INNER:
                    inner[inner_count] = point
                    inner_count += 1
            else:
                outside_sum += value
                if level == OUTER:
                    outer[outer_count] = point
                    outer_count += 1
    outside_count = height * width - inside_count

    iterations = 0
    before = -1
    while iterations < most_iterations and switches != before:
        iterations += 1
        before = switches
        smooth = 0.0
        if inner_count > 0 and abs(1.0 - outer_count / inner_count) > balance:
            smooth = regulariser
        kept, index, end = 0, 0, inner_count
        while index < end:
            point = inner[index]
            index += 1
            value = values[point]
            change = value
            if by_means:
                from_inside = value - inside_sum / inside_count
                from_outside = value - outside_sum / outside_count
                change = from_outside * from_outside * (outside_count / (outside_count + 1.0))
                change -= from_inside * from_inside * (inside_count / (inside_count - 1.0))
            if smooth != 0.0:
                change += smooth * (4 - _positive_neighbours(sides, point, stride))
            if change >= 0.0 or inside_count <= FEWEST:
                inner[kept] = point
                kept += 1
                continue
            sides[point] = OUTER
            outer[outer_count] = point
            outer_count += 1
            if switches < len(changes):
                changes[switches] = change
            switches += 1
            inside_count -= 1
            outside_count += 1
            inside_sum -= value
            outside_sum += value
            for neighbour in (point - stride, point - 1, point + 1, point + stride):
                inner_count = _join(sides, neighbour, INTERIOR, INNER, inner, inner_count)
            if flooding:
                end = inner_count
        while index < inner_count:
            inner[kept] = inner[index]
            kept += 1
            index += 1
        inner_count = kept
        outer_count = _drop_buried(sides, stride, outer, outer_count, OUTER, EXTERIOR)

        smooth = 0.0
        if outer_count > 0 and abs(1.0 - inner_count / outer_count) > balance:
            smooth = regulariser
        kept, index, end = 0, 0, outer_count
        while index < end:
            point = outer[index]
            index += 1
            value = values[point]
            change = -value
            if by_means:
                from_inside = value - inside_sum / inside_count
                from_outside = value - outside_sum / outside_count
                change = from_inside * from_inside * (inside_count / (inside_count + 1.0))
                change -= from_outside * from_outside * (outside_count / (outside_count - 1.0))
            if smooth != 0.0:
                change -= smooth * (4 - _positive_neighbours(sides, point, stride))
            if change >= 0.0 or outside_count <= FEWEST:
                outer[kept] = point
                kept += 1
                continue
            sides[point] = INNER
            inner[inner_count] = point
            inner_count += 1
            if switches < len(changes):
                changes[switches] = change
            switches += 1
            inside_count += 1
            outside_count -= 1
            inside_sum += value
            outside_sum -= value
            for neighbour in (point - stride, point - 1, point + 1, point + stride):
                outer_count = _join(sides, neighbour, EXTERIOR, OUTER, outer, outer_count)
            if flooding:
                end = outer_count
        while index < outer_count:
            outer[kept] = outer[index]
            kept += 1
            index += 1
        outer_count = kept
        inner_count = _drop_buried(sides, stride, inner, inner_count, INNER, INTERIOR)
    for row in range(height):
        for column in range(width):
            levels[row, column] = sides[(row + 1) * stride + column + 1]
    return iterations, switches == before, inside_count, inside_sum, outside_sum, switches
