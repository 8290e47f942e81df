"""Twin of `cable.statistics`, for states in columns, shape (8, N)."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.compiled.geometry import sine_and_cosine
from cable_tracker.cable.model.state import STATE_SIZE, StateColumn
from cable_tracker.compilation import compiled_fast

ANGLE = int(StateColumn.ANGLE)
BLOCK = 256
"""Particles at a time, so that their deviations stay in the nearest cache."""

SIGN_CHANGES = np.array([1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0])
"""Not zero for the components that change their sign when the normal is turned round."""


@compiled_fast
def mean_line_angle(angles: FloatArray, weights: FloatArray) -> float:
    """Return the mean direction of lines [rad] in (-pi/2, pi/2]; shapes (N,), (N,)."""
    sines, cosines = 0.0, 0.0
    for i in range(len(angles)):
        sine, cosine = sine_and_cosine(2.0 * angles[i])
        sines += weights[i] * sine
        cosines += weights[i] * cosine
    angle = 0.5 * math.atan2(sines, cosines)
    return angle + np.pi * math.floor((np.pi / 2 - angle) / np.pi)


@compiled_fast
def mean_and_covariance(
    states: FloatArray,
    weights: FloatArray,
    still: FloatArray,
    deviations: FloatArray,
    mean: FloatArray,
    covariance: FloatArray,
) -> None:
    """Write the mean (8,) and the covariance (8, 8) of states whose weights (N,) sum to one.

    Parameters
    ----------
    states : FloatArray
        Shape (8, N), angles in (-pi/2, pi/2].
    weights : FloatArray
        Shape (N,), summing to one.
    still : FloatArray
        Shape (4,): not zero where a rate is zero for all particles.
    deviations : FloatArray
        Shape (9, BLOCK): room.
    mean, covariance : FloatArray
        The answer.
    """
    reference = mean_line_angle(states[ANGLE], weights)
    # About the heaviest cable, moments of the second order need no second round.
    origin = np.argmax(weights)
    turned = abs(states[ANGLE, origin] - reference) > np.pi / 2
    centre = np.empty(STATE_SIZE)
    for c in range(STATE_SIZE):
        sign = -1.0 if turned and SIGN_CHANGES[c] != 0.0 else 1.0
        centre[c] = sign * states[c, origin]
    if turned:
        centre[ANGLE] += np.pi if centre[ANGLE] < reference else -np.pi
    mean[:] = 0.0
    covariance[:] = 0.0
    for start in range(0, len(weights), BLOCK):
        stop = min(start + BLOCK, len(weights))
        _deviate(states, start, stop, still, reference, centre, deviations)
        _add_moments(weights[start:stop], still, deviations, mean, covariance)
    for row in range(STATE_SIZE):
        for column in range(row + 1):
            value = covariance[row, column] - mean[row] * mean[column]
            if row == column:
                value = max(value, 0.0)
            covariance[row, column] = value
            covariance[column, row] = value
    for c in range(STATE_SIZE):
        mean[c] += centre[c]
    _wrap_estimate(mean, covariance)


@compiled_fast
def _deviate(
    states: FloatArray,
    start: int,
    stop: int,
    still: FloatArray,
    reference: float,
    centre: FloatArray,
    deviations: FloatArray,
) -> None:
    """Write deviations from a centre, in the chart about a reference angle; the signs come last."""
    count = stop - start
    signs = deviations[STATE_SIZE]
    angles = states[ANGLE, start:stop]
    for i in range(count):
        from_reference = angles[i] - reference
        half_turns = np.floor((np.pi / 2 - from_reference) / np.pi)
        signs[i] = 1.0 - 2.0 * abs(half_turns)  # At most half a turn either way.
        deviations[ANGLE, i] = angles[i] + half_turns * np.pi - centre[ANGLE]
    for c in range(STATE_SIZE):
        if c == ANGLE or (c >= 4 and still[c - 4] != 0.0):
            continue
        column, out, middle = states[c, start:stop], deviations[c], centre[c]
        if SIGN_CHANGES[c] != 0.0:
            for i in range(count):
                out[i] = signs[i] * column[i] - middle
        else:
            for i in range(count):
                out[i] = column[i] - middle


@compiled_fast
def _add_moments(
    weights: FloatArray,
    still: FloatArray,
    deviations: FloatArray,
    first: FloatArray,
    second: FloatArray,
) -> None:
    """Add the weighted sums of deviations, and of their products below the diagonal."""
    count = len(weights)
    weighted = deviations[STATE_SIZE]
    for row in range(STATE_SIZE):
        if row >= 4 and still[row - 4] != 0.0:
            continue
        values = deviations[row]
        total = 0.0
        for i in range(count):
            weighted[i] = weights[i] * values[i]
            total += weighted[i]
        first[row] += total
        for column in range(row + 1):
            if column >= 4 and still[column - 4] != 0.0:
                continue
            others = deviations[column]
            total = 0.0
            for i in range(count):
                total += weighted[i] * others[i]
            second[row, column] += total


@compiled_fast
def _wrap_estimate(mean: FloatArray, covariance: FloatArray) -> None:
    half_turns = math.floor((np.pi / 2 - mean[ANGLE]) / np.pi)
    mean[ANGLE] += half_turns * np.pi
    if half_turns % 2 == 0:
        return
    for row in range(STATE_SIZE):
        if SIGN_CHANGES[row] != 0.0:
            mean[row] = -mean[row]
        for column in range(STATE_SIZE):
            if SIGN_CHANGES[row] != SIGN_CHANGES[column]:
                covariance[row, column] = -covariance[row, column]
