"""Twin of `particle_filter.resampling`."""

from __future__ import annotations

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.compilation import compiled


@compiled
def invert_cumulative_weights(
    weights: FloatArray, positions: FloatArray, cumulative: FloatArray, indices: IndexArray
) -> None:
    """Write the index of the particle at each position.

    Parameters
    ----------
    weights : FloatArray
        Shape (N,), summing to one.
    positions : FloatArray
        Shape (M,), in ascending order, at least 0 and below 1.
    cumulative : FloatArray
        Shape (N,): room for the sums.
    indices : IndexArray
        Shape (M,): the answer.
    """
    total = 0.0
    last_possible = 0
    for i in range(len(weights)):
        before = total
        total += weights[i]
        cumulative[i] = total
        if total > before:
            last_possible = i
    particle, drawn = 0, 0
    # One step up either list at a time, without a branch that the processor could guess wrong.
    while drawn < len(positions):
        indices[drawn] = particle
        further = particle < last_possible and cumulative[particle] <= positions[drawn] * total
        particle += further
        drawn += 1 - further
