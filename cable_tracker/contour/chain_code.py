"""The outline of a mask as a chain code: a closed chain of steps to one of eight neighbours."""

from __future__ import annotations

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, IndexArray
from cable_tracker.errors import FrameError

ORIENTATIONS = np.array(((3, 2, 1), (4, -1, 0), (5, 6, 7)))
"""Orientation of a step [pi/4], by its steps in rows and columns, -1 to 1 each, plus one."""


def chain_code(mask: BoolArray) -> IndexArray:
    """Return the orientations of the steps once round a region, counter-clockwise as one sees it.

    The region is the one that holds the first point of the mask, in rows, where the chain begins.
    Holes in it and other regions are passed over.

    Parameters
    ----------
    mask : BoolArray
        Shape (H, W).

    Returns
    -------
    IndexArray
        0 to 7, in pi/4 counter-clockwise from the x axis, shape (M,); empty for one point.

    Raises
    ------
    FrameError
        The mask is empty.
    """
    if not mask.any():
        raise FrameError("an empty mask has no outline")
    row, column = divmod(int(np.argmax(mask)), mask.shape[1])
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    points = next(each[:, 0] for each in contours if tuple(each[0, 0]) == (column, row))
    steps = np.roll(points, -1, axis=0) - points + 1
    orientations: IndexArray = ORIENTATIONS[steps[:, 1], steps[:, 0]]
    return orientations[orientations >= 0]
