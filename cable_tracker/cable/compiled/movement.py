"""Twin of `cable.movement.CableMovement.propagate`, for states in columns, shape (8, N)."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.model.state import PLACES, StateColumn
from cable_tracker.compilation import compiled_fast

DISTANCE, ANGLE = int(StateColumn.DISTANCE), int(StateColumn.ANGLE)
SKEW = int(StateColumn.SKEW)
HALF_PI = np.pi / 2
BLOCK = 512
"""Particles at a time, so that what moves stays in the nearest cache."""

NOTHING = np.empty(0, np.int64)
"""Instead of ancestors, for example: every particle is its own."""


@compiled_fast
def drift(
    before: FloatArray,
    ancestors: IndexArray,
    still: FloatArray,
    time: float,
    damping: float,
    after: FloatArray,
    start: int,
    stop: int,
) -> None:
    """Write where the rates take the ancestors of the particles from `start` to `stop`.

    Parameters
    ----------
    before : FloatArray
        Shape (8, M).
    ancestors : IndexArray
        Indices into `before`, shape (N,), or empty if every particle is its own.
    still : FloatArray
        Shape (4,): not zero where a rate is zero for all particles.
    time, damping : float
        Time for which the undamped rates would cover the same way [s]; factor on the rates.
    after : FloatArray
        Shape (8, N); rates that are still are zero there and stay so.
    start, stop : int
        Range of particles.
    """
    for c in range(PLACES):
        places, rates = before[c], before[c + PLACES]
        new_places, new_rates = after[c], after[c + PLACES]
        moves = still[c] == 0.0
        if len(ancestors) > 0:
            for i in range(start, stop):
                new_places[i] = places[np.uint64(ancestors[i])]
            if moves:
                for i in range(start, stop):
                    new_rates[i] = rates[np.uint64(ancestors[i])]
        else:
            for i in range(start, stop):
                new_places[i] = places[i]
            if moves:
                for i in range(start, stop):
                    new_rates[i] = rates[i]
        if moves:
            for i in range(start, stop):
                new_places[i] += time * new_rates[i]
                new_rates[i] *= damping


@compiled_fast
def diffuse(
    states: FloatArray,
    noise: Image,
    stretches: FloatArray,
    sigmas: FloatArray,
    start: int,
    stop: int,
) -> None:
    """Add noise to the particles from `start` to `stop`, in place.

    Parameters
    ----------
    states : FloatArray
        Shape (8, N).
    noise : Image
        float32: a row of standard numbers for each component whose sigma is not zero, for these
        particles.
    stretches : FloatArray
        Shape (2, N): factors on the noise of places, and of rates; or (2, 0) for none.
    sigmas : FloatArray
        Shape (8,).
    start, stop : int
        Range of particles.
    """
    row = 0
    for c in range(len(sigmas)):
        sigma = sigmas[c]
        if sigma == 0.0:
            continue
        column, part = states[c, start:stop], noise[row]
        if stretches.shape[1] > 0:
            stretch = stretches[c // PLACES, start:stop]
            for i in range(len(column)):
                column[i] += sigma * stretch[i] * part[i]
        else:
            for i in range(len(column)):
                column[i] += sigma * part[i]
        row += 1


@compiled_fast
def wrap(states: FloatArray, start: int, stop: int) -> None:
    """Write particles of states (8, N) in place with their angle in (-pi/2, pi/2]."""
    angles, distances, skews = states[ANGLE], states[DISTANCE], states[SKEW]
    distance_rates, skew_rates = states[DISTANCE + PLACES], states[SKEW + PLACES]
    turned = 0.0
    for i in range(start, stop):
        turned += abs(np.floor((HALF_PI - angles[i]) / np.pi))
    if turned == 0.0:
        return
    for i in range(start, stop):
        half_turns = np.floor((HALF_PI - angles[i]) / np.pi)
        angles[i] += half_turns * np.pi
        odd = half_turns - 2.0 * np.floor(half_turns * 0.5)
        sign = 1.0 - 2.0 * odd
        distances[i] *= sign
        skews[i] *= sign
        distance_rates[i] *= sign
        skew_rates[i] *= sign


@compiled_fast
def keep_within(
    states: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    reflects: bool,
    start: int,
    stop: int,
) -> None:
    """Reflect or clip places of (8, N) at the limits (4,), in place; the angle has none."""
    for c in range(PLACES):
        if c == ANGLE:
            continue
        low, high = lower[c], upper[c]
        column = states[c, start:stop]
        if reflects:
            if c == DISTANCE:
                rates = states[c + PLACES, start:stop]
                for i in range(len(column)):
                    rates[i] = -rates[i] if abs(column[i]) > high else rates[i]
            for i in range(len(column)):
                value = column[i]
                mirrored = 2.0 * low - value if value < low else value
                column[i] = 2.0 * high - value if value > high else mirrored
        for i in range(len(column)):
            column[i] = min(max(column[i], low), high)
