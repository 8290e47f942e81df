"""Energies of the difference of two shapes: (19) to (22) of J. Ha (2008)."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.contour.chain_code import chain_code, segment_histograms
from cable_tracker.contour.shape_prior import signed_distances
from cable_tracker.errors import FrameError


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
