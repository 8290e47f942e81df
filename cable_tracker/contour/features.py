"""Feature points of an outline, and histograms of its orientations between them.

J. Ha (2008), chapter 4. Orientations are whole numbers 0 to 7, in pi/4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray

BINS = 8
HALF_TURN = 4
"""pi, in pi/4."""


@dataclass(frozen=True, slots=True)
class FeaturePoint:
    """Where an outline has turned far.

    Attributes
    ----------
    index : int
        Index of the point in the chain.
    is_convex : bool
        Whether the outline turns to the left after it, as round a bulge; of the start: False.
    """

    index: int
    is_convex: bool


def turns(orientations: IndexArray) -> IndexArray:
    """Return the turns between successive steps, -3 to 4, in pi/4, shape (M - 1,)."""
    wrapped: IndexArray = (np.diff(orientations) + 3) % BINS - 3
    return wrapped


def feature_points(orientations: IndexArray) -> list[FeaturePoint]:
    """Return the points after which an outline has turned by more than a half turn.

    The changes of orientation are summed; where the absolute sum exceeds pi, the point before is
    registered and the sum begins anew, with the turn there (our choice). The start is one.
    """
    found = [FeaturePoint(0, False)]
    total = 0
    for index, turn in enumerate(turns(orientations).tolist(), start=1):
        total += turn
        if abs(total) > HALF_TURN:
            found.append(FeaturePoint(index - 1, total > 0))
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
    starts = [point.index for point in feature_points(orientations)]
    ends = [*starts[1:], len(orientations)]
    return np.array(
        [
            orientation_histogram(orientations[start:end])
            for start, end in zip(starts, ends, strict=True)
        ]
    )


def upright_ratio(histogram: FloatArray) -> float:
    """Return vertical over horizontal steps; infinite if none is horizontal."""
    vertical, horizontal = histogram[2] + histogram[6], histogram[0] + histogram[4]
    return float(vertical / horizontal) if horizontal > 0.0 else float("inf")


def asymmetry(histogram: FloatArray) -> float:
    """Return how far a histogram is from symmetry under a half turn, 0 (man-made) to 1."""
    return float(np.abs(histogram - np.roll(histogram, HALF_TURN)).sum() / 2.0)
