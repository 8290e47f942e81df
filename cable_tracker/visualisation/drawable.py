"""Selection of hypotheses and particles to draw, in files and in the browser alike."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.state import CableState

LEAST_PROBABILITY = 0.05
"""Hypotheses below this are not drawn."""

LARGEST_SIGMA = 1e6
"""Standard deviation above which bands are no wider; they fill the picture anyway [px, rad]."""

REACH = 20.0
"""Length of lines beyond the picture, as a multiple of its longer side."""


def likely_states(hypotheses: Iterable[Hypothesis]) -> list[CableState]:
    """Return the states of the hypotheses that are drawn."""
    return [
        hypothesis.state
        for hypothesis in hypotheses
        if hypothesis.probability >= LEAST_PROBABILITY and hypothesis.state.is_finite()
    ]


def drawn_spread(sigma: Sequence[float] | FloatArray) -> tuple[float, float] | None:
    """Return the first two standard deviations as they are drawn; None if one is no number."""
    if not np.isfinite(sigma[:2]).all():
        return None
    return min(float(sigma[0]), LARGEST_SIGMA), min(float(sigma[1]), LARGEST_SIGMA)


def heaviest_rows(weights: FloatArray, usable: BoolArray, count: int) -> IndexArray:
    """Return the rows of the heaviest usable particles, lightest first.

    Parameters
    ----------
    weights : FloatArray
        Weights of all particles, shape (N,).
    usable : BoolArray
        Which of them can be drawn, shape (N,); without weight none is.
    count : int
        Largest number of rows.
    """
    chosen = np.flatnonzero(usable & (weights > 0.0))
    return chosen[np.argsort(weights[chosen], kind="stable")][-count:]


def within_reach(points: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Return points no farther from a picture than any line must go.

    Parameters
    ----------
    points : FloatArray
        Pixels of the picture, shape (..., 2).
    size : (int, int)
        Its width and height [px].
    """
    limit = REACH * max(size)
    return np.clip(points, -limit, limit)
