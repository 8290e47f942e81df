"""How wide a map shows a strip: where its borders are steepest need not be where the cable ends.

The brightness of a round cable falls off towards its silhouette, and grown over it is ragged there:
the steepest place of the picture lies inside, and the likelihood puts the border there. The network
has learnt where the silhouette is. It tells that to about a pixel, less finely than borders that
are crisp; so what it says is measured twice, and of the two the smaller counts.
"""

from __future__ import annotations

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.map.cable_map import (
    CableMap,
    is_worked_out,
    share_inside,
    strip_borders,
)
from cable_tracker.cable.measure.map.map_strips import refine_strip
from cable_tracker.cable.model.state import WIDTH
from cable_tracker.compilation import compiled, compiled_fast_loop, compiled_part

MAP_BLUR = 0.225
"""How much wider a map shows a crisp strip than it is [cells]."""

FARTHEST, NEAREST = 4.0, 1.0
"""Limits of how far beside a border cells are looked at: half the width within these [cells]."""

MOST_WIDENING = 0.4
"""Limit of the widening, of either sign, as a share of the width."""


@compiled
def map_widening(state: FloatArray, cable_map: CableMap) -> float:
    """Return how much wider than a strip (8,) a map shows it [px], below 0 if it is narrower.

    It is measured by the cells beside the borders and by the strip nearby that overlaps best with
    the map; 0 if they disagree which way, or there is no map.
    """
    if not is_worked_out(cable_map):
        return 0.0
    width, blur = state[WIDTH], MAP_BLUR * cable_map.cell
    by_cells = _widening_by_cells(state, cable_map) - blur
    nearby = state.copy()
    refine_strip(cable_map, nearby)
    by_strip: float = nearby[WIDTH] - width - blur
    if by_cells * by_strip <= 0.0:
        return 0.0
    smaller: float = min(abs(by_cells), abs(by_strip), MOST_WIDENING * width)
    return smaller if by_strip > 0.0 else -smaller


@compiled_part
def _widening_by_cells(state: FloatArray, cable_map: CableMap) -> float:
    """Return what cells beside both borders have more than those of the strip would [px]."""
    borders = strip_borders(state, state[WIDTH], cable_map)
    reach = min(max(0.5 * state[WIDTH] / cable_map.cell, NEAREST), FARTHEST)
    left = (borders.left, borders.left_row, borders.left_column)
    right = (borders.right, borders.right_row, borders.right_column)
    outwards = _outwards(left, reach, cable_map) + _outwards(right, reach, cable_map)
    return outwards * cable_map.cell


@compiled_fast_loop
def _outwards(border: tuple[float, float, float], reach: float, cable_map: CableMap) -> float:
    """Return how far outwards a map shows a border [cells].

    `border`: how far inwards the first cell lies, and what one row and one column change [cells];
    cells within `reach` of it are looked at.
    """
    excess, count = 0.0, 0
    rows, columns = cable_map.probabilities.shape
    for row in range(rows):
        for column in range(columns):
            inwards = border[0] + border[1] * row + border[2] * column
            if abs(inwards) <= reach:
                excess += cable_map.probabilities[row, column] - share_inside(inwards)
                count += 1
    # The cells within reach, over the width of their band, are the length of the border.
    return excess * 2.0 * reach / max(count, 1)
