"""The outline of a mask as a chain code: a closed chain of steps to one of eight neighbours.

Its feature points, and the histograms of orientations between them, are those of J. Ha (2008),
chapter 4. Orientations are whole numbers 0 to 7, in pi/4.
"""

from __future__ import annotations

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.errors import FrameError

ORIENTATIONS = np.array(((3, 2, 1), (4, -1, 0), (5, 6, 7)))
"""Orientation of a step [pi/4], by its steps in rows and columns, -1 to 1 each, plus one."""

BINS = 8
HALF_TURN = 4
"""pi, in pi/4."""


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


def turns(orientations: IndexArray) -> IndexArray:
    """Return the turns between successive steps, -3 to 4, in pi/4, shape (M - 1,)."""
    wrapped: IndexArray = (np.diff(orientations) + 3) % BINS - 3
    return wrapped


def feature_points(orientations: IndexArray) -> list[int]:
    """Return the indices of the points after which an outline has turned by more than a half turn.

    The changes of orientation are summed; where the absolute sum exceeds pi, the point before is
    registered and the sum begins anew, with the turn there (our choice). The start is one.
    """
    found = [0]
    total = 0
    for index, turn in enumerate(turns(orientations).tolist(), start=1):
        total += turn
        if abs(total) > HALF_TURN:
            found.append(index - 1)
            total = turn
    return found


def orientation_histogram(orientations: IndexArray) -> FloatArray:
    """Return the shares of the eight orientations, shape (8,), summing to one; zero for none."""
    counts = np.bincount(orientations, minlength=BINS).astype(np.float64)
    return counts / max(len(orientations), 1)


def segment_histograms(orientations: IndexArray) -> FloatArray:
    """Return the histogram of every segment between feature points, shape (segments, 8).

    The last segment leads back to the start.
    """
    starts = feature_points(orientations)
    ends = [*starts[1:], len(orientations)]
    return np.array(
        [
            orientation_histogram(orientations[start:end])
            for start, end in zip(starts, ends, strict=True)
        ]
    )
