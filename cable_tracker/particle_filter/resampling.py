"""Resampling: draw particles with a frequency proportional to their weight.

Every scheme is unbiased: particle i is drawn ``count * weights[i]`` times on average. They differ
in the variance that they add. All take the weights, shape (N,), summing to one; the number of
particles to draw; and a random generator; and return indices, shape (count,).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray

ResamplingScheme: TypeAlias = Callable[[FloatArray, int, np.random.Generator], IndexArray]

ROUNDING = 1e-9
"""An expected number of copies this much below a whole number is that number."""


SMALLEST_STEP = 1e-300
"""Steps that are all zero have no sum to divide by."""


def _invert_cumulative_weights(weights: FloatArray, positions: FloatArray) -> IndexArray:
    """Return the particle on which each position from 0 to 1 falls, shape (count,)."""
    reached = np.cumsum(weights)
    total = reached[-1]
    # Scaling the positions instead of forcing the last sum to one: rounding must neither draw a
    # particle of weight zero at the end nor run past it.
    found = np.searchsorted(reached, positions * total, side="right")
    indices: IndexArray = np.minimum(found, np.searchsorted(reached, total))
    return indices


def multinomial_positions(count: int, rng: np.random.Generator) -> FloatArray:
    """Draw independent positions in [0, 1), and sort them; shape (count,).

    Sorted, they are distributed like the partial sums of exponential numbers over the whole sum,
    which takes no sorting (Devroye, 1986, section V.3).
    """
    # In place, for with many particles the time goes into memory.
    steps = rng.random(count + 1)
    np.subtract(1.0, steps, out=steps)
    np.log(steps, out=steps)
    np.negative(steps, out=steps)
    np.maximum(steps, SMALLEST_STEP, out=steps)
    np.cumsum(steps, out=steps)
    steps /= steps[-1]
    positions: FloatArray = steps[:-1]
    return positions


def multinomial_resampling(weights: FloatArray, count: int, rng: np.random.Generator) -> IndexArray:
    """Draw independently, by search in the cumulative weights (thesis, section 3.3.3)."""
    return _invert_cumulative_weights(weights, multinomial_positions(count, rng))


def stratified_resampling(weights: FloatArray, count: int, rng: np.random.Generator) -> IndexArray:
    """Draw one position at random from each of `count` equal strata (Kitagawa, 1996)."""
    return _invert_cumulative_weights(weights, (np.arange(count) + rng.random(count)) / count)


def systematic_resampling(weights: FloatArray, count: int, rng: np.random.Generator) -> IndexArray:
    """Draw equally spaced positions with one random offset (Carpenter et al., 1999)."""
    return _invert_cumulative_weights(weights, (np.arange(count) + rng.random()) / count)


def residual_resampling(weights: FloatArray, count: int, rng: np.random.Generator) -> IndexArray:
    """Copy each particle floor(count * weight) times, draw the rest at random (Liu, Chen, 1998)."""
    expected = weights * count
    # A weight of 1/N that rounding has made a little smaller still earns its copy.
    copies = np.floor(expected + ROUNDING).astype(np.int64)
    certain = np.repeat(np.arange(len(weights), dtype=np.int64), copies)
    missing = count - len(certain)
    if missing <= 0:
        return certain[:count]
    residual = np.maximum(expected - copies, 0.0)
    total = residual.sum()
    # Rounding may leave a missing particle without a residual to draw it from.
    rest = residual / total if total > 0 else weights
    return np.concatenate((certain, multinomial_resampling(rest, missing, rng)))


RESAMPLING_SCHEMES: Mapping[str, ResamplingScheme] = MappingProxyType(
    {
        "multinomial": multinomial_resampling,
        "stratified": stratified_resampling,
        "systematic": systematic_resampling,
        "residual": residual_resampling,
    }
)
