"""Shapes of masks: distances from an outline, chain codes, and how much two shapes differ.

Signed distances make a soft shape prior, the log-odds that a pixel is inside. An outline as a chain
code is a closed chain of steps to one of eight neighbours; its feature points, and the histograms
of orientations between them, are those of J. Ha (2008), chapter 4, with orientations as whole
numbers 0 to 7, in pi/4. The energies of the difference of two shapes are (19) to (22) there.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.errors import FrameError
from cable_tracker.libraries import without_ipp

ORIENTATIONS = np.array(((3, 2, 1), (4, -1, 0), (5, 6, 7)))
"""Orientation of a step [pi/4], by its steps in rows and columns, -1 to 1 each, plus one."""

BINS = 8
HALF_TURN = 4
"""pi, in pi/4."""


def signed_distances(mask: BoolArray) -> NDArray[np.float32]:
    """Return the distance of every pixel from the outline of a mask, negative inside [px].

    The outline runs between the pixels: the nearest on either side are half a pixel off. What lies
    beyond the picture is outside. All outside has no outline: every distance is the picture's
    diagonal less half a pixel.
    """
    inside = np.pad(mask, 1).astype(np.uint8)
    to_outside, to_inside = _distances_to_zero(inside), _distances_to_zero(1 - inside)
    if not mask.any():
        height, width = mask.shape
        to_inside = np.full(inside.shape, np.hypot(height, width), np.float32)
    signed = np.where(inside > 0, 0.5 - to_outside, to_inside - 0.5)
    cut: NDArray[np.float32] = signed[1:-1, 1:-1].astype(np.float32)
    return cut


def _distances_to_zero(values: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the distance of every pixel from the nearest zero [px]."""
    with without_ipp():
        distances = cv2.distanceTransform(values, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return distances.astype(np.float32, copy=False)


def log_odds(distances: NDArray[np.float32], softness: float, limit: float) -> NDArray[np.float32]:
    """Return the log-odds of being inside, given the distances from an expected outline.

    Parameters
    ----------
    distances : array
        Signed distances from the outline, negative inside, float32, shape (H, W).
    softness : float
        Distance from the outline at which the odds are e : 1, in the unit of `distances`.
    limit : float
        Largest log-odds.
    """
    odds: NDArray[np.float32] = np.clip(-distances / np.float32(softness), -limit, limit)
    return odds


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


def level_set_energy(first: BoolArray, second: BoolArray) -> float:
    """Return d^2 of (19, 20): the squared difference of two signed distances, averaged [px²].

    The average is over the insides, each normalised: (h1 + h2)/2 with h = H/∫H.

    Raises
    ------
    FrameError
        The shapes of the arrays differ, or a mask is empty.
    """
    if first.shape != second.shape:
        raise FrameError(f"masks of shape {first.shape} and {second.shape} cannot be compared")
    if not first.any() or not second.any():
        raise FrameError("an empty mask has no shape")
    squared = (signed_distances(first) - signed_distances(second)) ** 2
    return float(0.5 * (squared[first].mean() + squared[second].mean()))


def histogram_energy(first: FloatArray, second: FloatArray) -> float:
    """Return E_cs of (21): squared differences of histograms, over segments and bins.

    The segments of the shorter list are paired with as many of the longer one, in order; one
    without a partner is compared with an empty histogram (our choice).

    Parameters
    ----------
    first, second : FloatArray
        Histograms of `segment_histograms`, shape (segments, 8).
    """
    count = max(len(first), len(second))
    padded = [np.vstack((rows, np.zeros((count - len(rows), 8)))) for rows in (first, second)]
    return float(((padded[0] - padded[1]) ** 2).sum())


def shape_energy(
    first: BoolArray, second: BoolArray, level_weight: float, histogram_weight: float
) -> float:
    """Return E_S of (22): both energies, weighted. The thesis gives no weights.

    Raises
    ------
    FrameError
        As for `level_set_energy`.
    """
    energy = level_weight * level_set_energy(first, second)
    if histogram_weight != 0.0:
        histograms = [segment_histograms(chain_code(mask)) for mask in (first, second)]
        energy += histogram_weight * histogram_energy(histograms[0], histograms[1])
    return energy
