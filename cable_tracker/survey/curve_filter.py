"""A Kalman filter along a cable, and the smoother of Rauch, Tung and Striebel; see `smoothing`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.compilation import compiled
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.survey.keyframes import Keyframes

BEND_LENGTH = 6.0
"""Arc length over which the curvature forgets itself [m]."""

ROUGHNESS = 1e-4
"""Variance that odometry adds to the place, per second [m²/s]."""

FIRST = (4.0, math.radians(30.0) ** 2)
"""Variances of place and direction where nothing is known [m², rad²]."""

LEAST_SLOPE = 0.2
"""Least cosine of the angle between a cable and the look line's own direction: from less it cannot
be followed to the next look line."""


class SmoothedCable(NamedTuple):
    """Smoothed state of the cable at S keyframes; its arrays are written in place.

    Attributes
    ----------
    along : FloatArray
        Arc length along the cable since the first keyframe, shape (S,) [m]; smaller where the
        vehicle went back.
    states : FloatArray
        Place beside the look line, direction from it, curvature, shape (S, 3) [m, rad, 1/m].
    covariances : FloatArray
        Covariances of the states, shape (S, 3, 3).
    weights : FloatArray
        Weight of each claim, 0 to about 1, shape (S,); 0 without a claim, or for one that is of
        something else.
    piece : IndexArray
        Number of the connected piece that a keyframe belongs to, shape (S,); another one where the
        keyframe does not go on from the one before, or where the vehicle has turned away from the
        cable, or round.
    scales : (float, float)
        Factors by which the tracker's standard deviations of place and direction were too small.
    bend : float
        Standard deviation of the cable's curvature [1/m].
    """

    along: FloatArray
    states: FloatArray
    covariances: FloatArray
    weights: FloatArray
    piece: IndexArray
    scales: tuple[float, float]
    bend: float


@compiled
def _moved(before: FloatArray, after: FloatArray, state: FloatArray) -> FloatArray:
    """Return y, h, kappa of a cable at the next look line (3,), and the arc length to it."""
    turn = after[2] - before[2]
    cos, sin = math.cos(turn), math.sin(turn)
    dx, dy = after[0] - before[0], after[1] - before[1]
    c0, s0 = math.cos(before[2]), math.sin(before[2])
    ahead, aside = dx * c0 + dy * s0, -dx * s0 + dy * c0
    bx = -ahead * cos + (state[0] - aside) * sin
    by = ahead * sin + (state[0] - aside) * cos
    heading = state[1] - turn
    slope = math.cos(heading)
    result = np.empty(4)
    # The cable lies across the look line, or the vehicle has turned round.
    if slope < LEAST_SLOPE:
        result[:] = np.nan
        return result
    arc = -bx / slope
    result[0] = by + arc * math.sin(heading) + 0.5 * state[2] * arc * arc / slope
    result[1] = heading + state[2] * arc
    result[2] = state[2]
    result[3] = arc
    return result


@compiled
def _transition(before: FloatArray, moved: FloatArray) -> FloatArray:
    """Return the transition matrix of changes of y, h, kappa to the next look line, (3, 3)."""
    arc = moved[3]
    slope = math.cos(moved[1] - before[2] * arc)
    move = np.zeros((3, 3))
    move[0, 0] = math.cos(before[1]) / slope
    move[0, 1] = arc / slope
    move[0, 2] = 0.5 * arc * arc / slope
    move[1, 1] = 1.0
    move[1, 2] = arc
    move[2, 2] = math.exp(-abs(arc) / BEND_LENGTH)
    return move


@compiled
def _bending(arc: float, bend: float) -> FloatArray:
    """Return the process noise of a randomly changing curvature over a distance, (3, 3)."""
    size = abs(arc)
    fresh = bend * bend * (1.0 - math.exp(-2.0 * size / BEND_LENGTH))
    noise = np.empty((3, 3))
    noise[0, 0] = fresh * size**4 / 20.0
    noise[0, 1] = noise[1, 0] = fresh * size * size * arc / 8.0
    noise[0, 2] = noise[2, 0] = fresh * size * size / 6.0
    noise[1, 1] = fresh * size * size / 3.0
    noise[1, 2] = noise[2, 1] = fresh * arc / 2.0
    noise[2, 2] = fresh
    return noise


@compiled
def _predicted(
    mean: FloatArray, spread: FloatArray, moved: FloatArray, seconds: float, bend: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mean (3,) and covariance (3, 3) at the next look line, and the transition to it."""
    move = _transition(mean, moved)
    ahead = move @ spread @ move.T + _bending(moved[3], bend)
    ahead[0, 0] += ROUGHNESS * max(seconds, 0.0)
    there = moved[:3].copy()
    there[2] *= move[2, 2]
    return there, ahead, move


@compiled
def _claimed(
    mean: FloatArray, spread: FloatArray, claim: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return mean (3,) and covariance (3, 3) after a claim (2,) with noise r00, r01, r11."""
    s00, s01 = spread[0, 0] + noise[0], spread[0, 1] + noise[1]
    s11 = spread[1, 1] + noise[2]
    inverse = np.array([[s11, -s01], [-s01, s00]]) / (s00 * s11 - s01 * s01)
    gain = np.ascontiguousarray(spread[:, :2]) @ inverse
    after = spread - gain @ np.ascontiguousarray(spread[:2, :])
    return mean + gain @ (claim - mean[:2]), 0.5 * (after + after.T)


@compiled
def filter_forwards(
    keyframes: Keyframes, noise: FloatArray, first: int, cable: SmoothedCable
) -> None:
    """Filter K keyframes from `first` on, and write `cable` there.

    `noise` is that of their claims, shape (K, 3); of the other arrays one row before the first is
    read.
    """
    look_lines, stamps, claims, bend = (
        keyframes.look_lines,
        keyframes.stamps,
        keyframes.claims,
        cable.bend,
    )
    along, states, covariances, piece = cable.along, cable.states, cable.covariances, cable.piece
    moved = np.zeros(4)
    for k in range(first, first + len(noise)):
        piece[k] = piece[k - 1] if k > 0 else -1
        is_new = keyframes.breaks[k]
        if not is_new:
            moved = _moved(look_lines[k - 1], look_lines[k], states[k - 1])
            is_new = not np.isfinite(moved[3])
        if is_new:
            # The arc length since then is not of the cable before: a vehicle that has turned away
            # goes on along nothing, and one that has turned round along the same cable again.
            piece[k] += 1
            mean, spread = np.zeros(3), np.diag(np.array((*FIRST, bend * bend)))
            along[k] = along[k - 1] if k > 0 else 0.0
        else:
            along[k] = along[k - 1] + moved[3]
            seconds = (stamps[k] - stamps[k - 1]) / NANOSECONDS
            mean, spread, _ = _predicted(states[k - 1], covariances[k - 1], moved, seconds, bend)
        if cable.weights[k] > 0.0:
            mean, spread = _claimed(mean, spread, claims[k], noise[k - first] / cable.weights[k])
        states[k], covariances[k] = mean, spread


@compiled
def smooth_backwards(keyframes: Keyframes, first: int, last: int, cable: SmoothedCable) -> None:
    """Smooth `cable` at the keyframes from the one before `last` back to `first`."""
    look_lines, stamps = keyframes.look_lines, keyframes.stamps
    states, covariances, piece = cable.states, cable.covariances, cable.piece
    for k in range(min(last, len(look_lines) - 1) - 1, first - 1, -1):
        if piece[k + 1] != piece[k]:
            continue
        # What was predicted is worked out again: kept, it would be most of what this takes.
        moved = _moved(look_lines[k], look_lines[k + 1], states[k])
        seconds = (stamps[k + 1] - stamps[k]) / NANOSECONDS
        mean, spread, move = _predicted(states[k], covariances[k], moved, seconds, cable.bend)
        back = covariances[k] @ move.T @ np.linalg.inv(spread)
        states[k] += back @ (states[k + 1] - mean)
        spread = covariances[k] + back @ (covariances[k + 1] - spread) @ back.T
        covariances[k] = 0.5 * (spread + spread.T)
