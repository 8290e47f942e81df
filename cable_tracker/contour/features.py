"""Feature points of an outline, and histograms of its orientations between them.

J. Ha (2008), chapter 4. Orientations are whole numbers 0 to 7, in pi/4.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray

BINS = 8
HALF_TURN = 4
"""pi, in pi/4."""


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
