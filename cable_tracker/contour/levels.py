"""The four-valued level set of the fast contour: exterior, interior, and the two lists between.

After J. Ha, "Visual tracking and control" (2008), chapter 3.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray
from cable_tracker.compilation import compiled

Levels: TypeAlias = NDArray[np.int8]
"""Shape (H, W): EXTERIOR, OUTER, INNER or INTERIOR at every pixel."""

EXTERIOR, OUTER, INNER, INTERIOR = 3, 1, -1, -3
"""Outside; outside with a 4-neighbour inside; inside with a 4-neighbour outside; inside."""


@compiled
def levels_of_mask(mask: BoolArray) -> Levels:
    """Return the level set whose inside is a mask, shape (H, W).

    What lies beyond the picture is neither inside nor outside: it makes no contour.
    """
    height, width = mask.shape
    levels = np.empty((height, width), np.int8)
    for row in range(height):
        for column in range(width):
            here = mask[row, column]
            differs = (
                (row > 0 and mask[row - 1, column] != here)
                or (row + 1 < height and mask[row + 1, column] != here)
                or (column > 0 and mask[row, column - 1] != here)
                or (column + 1 < width and mask[row, column + 1] != here)
            )
            if here:
                levels[row, column] = INNER if differs else INTERIOR
            else:
                levels[row, column] = OUTER if differs else EXTERIOR
    return levels
