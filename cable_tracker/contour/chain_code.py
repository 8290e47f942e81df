"""The outline of a mask as a closed chain of steps to one of eight neighbours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, IndexArray
from cable_tracker.compilation import compiled
from cable_tracker.errors import FrameError

COLUMN_STEPS = np.array([1, 1, 0, -1, -1, -1, 0, 1])
ROW_STEPS = np.array([0, -1, -1, -1, 0, 1, 1, 1])
"""Row and column steps of the orientations k pi/4, counter-clockwise, rows counted downwards."""


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """A closed outline, once round counter-clockwise as one sees it.

    Attributes
    ----------
    points : IndexArray
        Column and row of every point, shape (M, 2) [px].
    orientations : IndexArray
        Orientation of the step from each point to the next, 0 to 7, in pi/4, shape (M,); empty for
        one point.
    """

    points: IndexArray
    orientations: IndexArray


def outline(mask: BoolArray) -> Chain:
    """Follow the outline of the region that holds the first point of a mask, in rows.

    Holes in it and other regions are passed over.

    Raises
    ------
    FrameError
        The mask is empty.
    """
    if not mask.any():
        raise FrameError("an empty mask has no outline")
    start = int(np.argmax(mask))
    steps = _follow(np.pad(mask, 1), start // mask.shape[1] + 1, start % mask.shape[1] + 1)
    first = np.array([start % mask.shape[1], start // mask.shape[1]], dtype=np.int64)
    moves = np.stack((COLUMN_STEPS[steps], ROW_STEPS[steps]), axis=1)
    points = np.vstack((first[None], first + np.cumsum(moves, axis=0)))
    # The last step leads back to the start.
    return Chain(points[:-1] if len(steps) else points, steps)


@compiled
def _follow(mask: BoolArray, row: int, column: int) -> IndexArray:
    """Walk once round, keeping the outside to the right; the mask has an empty margin.

    The first point has nothing above it and nothing to its left in its row.
    """
    steps = np.empty(4 * mask.size, np.int64)
    count = 0
    first_row, first_column = row, column
    first_step = -1
    direction = 7
    while True:
        # From the last outside neighbour on the right, turn left until there is a way.
        direction = (direction + 7) % 8 if direction % 2 == 0 else (direction + 6) % 8
        found = False
        for _ in range(8):
            if mask[row + ROW_STEPS[direction], column + COLUMN_STEPS[direction]]:
                found = True
                break
            direction = (direction + 1) % 8
        if not found:
            return steps[:0]
        if row == first_row and column == first_column:
            if direction == first_step:
                return steps[:count]
            if first_step < 0:
                first_step = direction
        steps[count] = direction
        count += 1
        row += ROW_STEPS[direction]
        column += COLUMN_STEPS[direction]
