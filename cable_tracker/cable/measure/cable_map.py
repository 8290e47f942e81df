"""Where in a picture a cable may be: the probability of each cell, and how a strip lies on it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.geometry import border_offset
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, WIDTH
from cable_tracker.compilation import compiled, compiled_fast_loop, compiled_inside

SMALLEST_SHARE = 0.01
"""Added to a share and to the rest before their ratio is taken: no cell is sure."""

SMALLEST_AREA = 0.5
"""Area that a strip is taken to have at least [cells]."""


class CableMap(NamedTuple):
    """Probabilities that cells of the picture are part of a cable.

    Attributes
    ----------
    probabilities : Image
        float32, shape (rows, columns), from the top left; (0, 0) if they were not worked out.
    mass : float
        Their sum.
    left, top : float
        Coordinates of the centre of the first cell in the image frame, y up [px].
    cell : float
        Side of a cell [px].
    """

    probabilities: Image
    mass: float
    left: float
    top: float
    cell: float


NO_MAP = CableMap(np.empty((0, 0), np.float32), 0.0, 0.0, 0.0, 1.0)
"""The map of a frame of which none was worked out."""


class MapMatch(NamedTuple):
    """How well a strip matches a map.

    Attributes
    ----------
    overlap : float
        Log-odds of the overlap of the strip with what the map takes for cable: twice what both have
        in common over the sum of both [nats].
    inside : float
        Log-odds of the mean probability inside the strip [nats].
    """

    overlap: float
    inside: float


@compiled_fast_loop
def map_match(state: FloatArray, where: CableMap) -> MapMatch:
    """Return how well a strip (8,) matches a map that is not empty."""
    area, mass = _covered(state, where)
    area = max(area, SMALLEST_AREA)
    return MapMatch(
        _log_odds(2.0 * mass / (where.mass + area)),
        _log_odds(min(mass / area, 1.0)),
    )


@compiled
def strip_shares(state: FloatArray, where: CableMap) -> Image:
    """Return which share of each cell of a map a strip (8,) covers, float32, of the map's shape."""
    shares: Image = np.empty(where.probabilities.shape, np.float32)
    borders = _borders(state, where)
    for row in range(shares.shape[0]):
        for column in range(shares.shape[1]):
            shares[row, column] = _share(row, column, borders)
    return shares


@compiled_fast_loop
def _covered(state: FloatArray, where: CableMap) -> tuple[float, float]:
    """Return the number of cells that a strip covers, and the sum of their probabilities."""
    probabilities, borders = where.probabilities, _borders(state, where)
    area, mass = 0.0, 0.0
    for row in range(probabilities.shape[0]):
        for column in range(probabilities.shape[1]):
            share = _share(row, column, borders)
            area += share
            mass += share * probabilities[row, column]
    return area, mass


class _Borders(NamedTuple):
    """How far inwards of each border the centre of a cell lies [cells]: linear in row and column.

    The distance from the left border is left + left_row * row + left_column * column.
    """

    left: float
    left_row: float
    left_column: float
    right: float
    right_row: float
    right_column: float


@compiled_fast_loop
def _borders(state: FloatArray, where: CableMap) -> _Borders:
    """Return the borders of a strip as they cross the cells of a map."""
    angle, width, skew = state[ANGLE], state[WIDTH], state[SKEW]
    left_x, left_y = math.cos(angle - skew), math.sin(angle - skew)
    right_x, right_y = math.cos(angle + skew), math.sin(angle + skew)
    left_offset = border_offset(state[DISTANCE], width, skew, -1.0)
    right_offset = border_offset(state[DISTANCE], width, skew, 1.0)
    return _Borders(
        (where.left * left_x + where.top * left_y - left_offset) / where.cell,
        -left_y,
        left_x,
        (right_offset - where.left * right_x - where.top * right_y) / where.cell,
        right_y,
        -right_x,
    )


@compiled_inside
def _share(row: int, column: int, borders: _Borders) -> float:
    """Return which share of a cell lies between the borders, as of one across its middle."""
    after = borders.left + borders.left_row * row + borders.left_column * column + 0.5
    before = borders.right + borders.right_row * row + borders.right_column * column + 0.5
    return min(max(after, 0.0), 1.0) * min(max(before, 0.0), 1.0)


@compiled_inside
def _log_odds(share: float) -> float:
    """Return the log-odds of a share, 0 to 1, bounded [nats]."""
    return math.log((share + SMALLEST_SHARE) / (1.0 + SMALLEST_SHARE - share))
