"""The strips that a map of the frame shows best: where to look for a cable whose borders are faint.

For each direction of a fan, the cells are added up along it, and of all intervals across it the
one that overlaps most with what the map takes for cable is a strip without skew. The best of all
directions is then moved, turned, widened and skewed while its overlap grows. What it covers is
taken away, and the next one is looked for.
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.map.cable_map import (
    SMALLEST_AREA,
    CableMap,
    cable_map_of,
    map_overlap,
    strip_shares,
)
from cable_tracker.cable.model.state import ANGLE, DISTANCE, POSE_SIZE, SKEW, STATE_SIZE, WIDTH
from cable_tracker.compilation import compiled, compiled_fast_loop, compiled_part

DIRECTIONS = 36
"""Number of directions of the fan."""

FIRST_STEPS = np.array([2.0, math.radians(3.0), 2.0, math.radians(3.0)])
"""First steps by which d, alpha, w and beta are changed [cells, rad]."""

HALVINGS, TRIES = 3, 4
"""How often the steps are halved, and how often each is tried at one size."""

MOST_SKEW = math.radians(25.0)
"""Largest skew of a strip that is proposed [rad]; particles about it may have more."""


@compiled
def strips_of_map(cable_map: CableMap, most: int) -> FloatArray:
    """Return at most `most` strips that a map shows, best first, shape (C, 8), rates 0.

    Each is one whose overlap with the map grows no further by a small change. A map without cells,
    or with next to nothing in them, has none.
    """
    strips, rest = np.zeros((most, STATE_SIZE)), cable_map
    for count in range(most):
        if rest.mass < SMALLEST_AREA:
            return strips[:count]
        strip = strips[count]
        _fill_straight_strip(rest, strip)
        refine_strip(rest, strip)
        left = rest.probabilities * (np.float32(1.0) - strip_shares(strip, cable_map))
        rest = cable_map_of(left, cable_map.left, cable_map.top, cable_map.cell)
    return strips


@compiled_part
def _fill_straight_strip(cable_map: CableMap, strip: FloatArray) -> None:
    """Fill in the strip without skew of the largest overlap over all directions."""
    rows, columns = cable_map.probabilities.shape
    bins = math.ceil(math.hypot(rows, columns)) + 1
    masses, areas = np.empty(bins + 1), np.empty(bins + 1)
    best = -1.0
    for direction in range(DIRECTIONS):
        angle = (direction + 0.5) / DIRECTIONS * math.pi - 0.5 * math.pi
        first = _add_up_across(cable_map, angle, masses, areas)
        for begin in range(bins):
            for end in range(begin + 1, bins + 1):
                area, mass = areas[end] - areas[begin], masses[end] - masses[begin]
                overlap = mass / (cable_map.mass + max(area, SMALLEST_AREA))
                if overlap > best:
                    best = overlap
                    strip[DISTANCE] = first + 0.5 * (begin + end) * cable_map.cell
                    strip[ANGLE], strip[WIDTH] = angle, (end - begin) * cable_map.cell


@compiled_fast_loop
def _add_up_across(
    cable_map: CableMap, angle: float, masses: FloatArray, areas: FloatArray
) -> float:
    """Fill in what lies before each step across a direction, shape (B + 1,): mass and cells.

    Steps are one cell wide; where the first one begins is returned [px].
    """
    rows, columns = cable_map.probabilities.shape
    across, down = math.cos(angle), -math.sin(angle)
    lowest = min(0.0, across * (columns - 1)) + min(0.0, down * (rows - 1)) - 0.5
    masses[:], areas[:] = 0.0, 0.0
    for row in range(rows):
        for column in range(columns):
            step = int(across * column + down * row - lowest) + 1
            masses[step] += cable_map.probabilities[row, column]
            areas[step] += 1.0
    for step in range(1, len(masses)):
        masses[step] += masses[step - 1]
        areas[step] += areas[step - 1]
    first: float = cable_map.left * across - cable_map.top * down + lowest * cable_map.cell
    return first


@compiled_part
def refine_strip(cable_map: CableMap, strip: FloatArray) -> None:
    """Change a strip (8,), one number at a time, while its overlap with the map grows."""
    steps = FIRST_STEPS.copy()
    steps[DISTANCE] *= cable_map.cell
    steps[WIDTH] *= cable_map.cell
    best = map_overlap(strip, cable_map)
    for _ in range(HALVINGS + 1):
        for _ in range(TRIES):
            before = best
            for column in range(POSE_SIZE):
                for sign in (-1.0, 1.0):
                    best = _try_step(cable_map, strip, column, sign * steps[column], best)
            if best == before:
                break
        steps *= 0.5


@compiled_part
def _try_step(
    cable_map: CableMap, strip: FloatArray, column: int, step: float, best: float
) -> float:
    """Change one number of a strip if its overlap grows, and return the overlap."""
    kept = strip[column]
    strip[column] += step
    overlap = map_overlap(strip, cable_map)
    if overlap > best and abs(strip[SKEW]) <= MOST_SKEW and strip[WIDTH] >= 0.5 * cable_map.cell:
        return overlap
    strip[column] = kept
    return best
