"""A Kalman filter along a cable, and the smoother of Rauch, Tung and Striebel; see `smoothing`."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.compilation import compiled

BEND_LENGTH = 6.0
"""Way over which the curvature forgets itself [m]."""

ROUGHNESS = 1e-4
"""Variance that odometry adds to the place, per second [m²/s]."""

FIRST = (4.0, math.radians(30.0) ** 2)
"""Variances of place and direction where nothing is known [m², rad²]."""

LEAST_SLOPE = 0.2
"""Least cosine of the angle between a cable and the look line's own direction: from less it cannot
be followed to the next look line."""


class KeyframeClaims(NamedTuple):
    """What is known at S keyframes of the cable, and how one follows the other.

    Attributes
    ----------
    places : FloatArray
        Position and direction of the look lines, shape (S, 3) [m, rad].
    seconds : FloatArray
        Time from the keyframe before to each, shape (S,) [s].
    claims : FloatArray
        Place beside the look line and direction from it, shape (S, 2) [m, rad].
    weights : FloatArray
        Weights of the claims, shape (S,); 0: none.
    breaks : BoolArray
        Whether a keyframe does not go on from the one before, shape (S,).
    """

    places: FloatArray
    seconds: FloatArray
    claims: FloatArray
    weights: FloatArray
    breaks: BoolArray


class CurveStates(NamedTuple):
    """The cable at S keyframes, as it is written.

    Attributes
    ----------
    along : FloatArray
        Way along the cable, shape (S,) [m].
    means, spreads : FloatArray
        State y, h, kappa, shape (S, 3), and its covariance, shape (S, 3, 3).
    is_new : BoolArray
        Whether nothing of the state before went into a state, shape (S,): where the keyframe does
        not go on from the one before, or lies across the cable.
    """

    along: FloatArray
    means: FloatArray
    spreads: FloatArray
    is_new: BoolArray


@compiled
def _moved(place: FloatArray, after: FloatArray, state: FloatArray) -> FloatArray:
    """Return a cable's state at the next look line, and the way to it: y, h, kappa, s."""
    turn = after[2] - place[2]
    cos, sin = math.cos(turn), math.sin(turn)
    dx, dy = after[0] - place[0], after[1] - place[1]
    c0, s0 = math.cos(place[2]), math.sin(place[2])
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
    way = -bx / slope
    result[0] = by + way * math.sin(heading) + 0.5 * state[2] * way * way / slope
    result[1] = heading + state[2] * way
    result[2] = state[2]
    result[3] = way
    return result


@compiled
def _transition(before: FloatArray, moved: FloatArray) -> FloatArray:
    """Return how small changes of y, h, kappa go on from one look line to the next, (3, 3)."""
    way = moved[3]
    slope = math.cos(moved[1] - before[2] * way)
    move = np.zeros((3, 3))
    move[0, 0] = math.cos(before[1]) / slope
    move[0, 1] = way / slope
    move[0, 2] = 0.5 * way * way / slope
    move[1, 1] = 1.0
    move[1, 2] = way
    move[2, 2] = math.exp(-abs(way) / BEND_LENGTH)
    return move


@compiled
def _bending(way: float, bend: float) -> FloatArray:
    """Return what a curvature that changes at random adds over a way, (3, 3)."""
    size = abs(way)
    fresh = bend * bend * (1.0 - math.exp(-2.0 * size / BEND_LENGTH))
    noise = np.empty((3, 3))
    noise[0, 0] = fresh * size**4 / 20.0
    noise[0, 1] = noise[1, 0] = fresh * size * size * way / 8.0
    noise[0, 2] = noise[2, 0] = fresh * size * size / 6.0
    noise[1, 1] = fresh * size * size / 3.0
    noise[1, 2] = noise[2, 1] = fresh * way / 2.0
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
    known: KeyframeClaims, noise: FloatArray, bend: float, first: int, cable: CurveStates
) -> None:
    """Filter K keyframes from `first` on, and write `cable` there.

    `noise` is that of their claims, shape (K, 3); of the other arrays one row before the first is
    read.
    """
    places, seconds, claims, weights, breaks = known
    along, means, spreads, is_new = cable
    moved = np.zeros(4)
    for k in range(first, first + len(noise)):
        is_new[k] = breaks[k]
        if not is_new[k]:
            moved = _moved(places[k - 1], places[k], means[k - 1])
            is_new[k] = not np.isfinite(moved[3])
        if is_new[k]:
            mean, spread = np.zeros(3), np.diag(np.array((*FIRST, bend * bend)))
            along[k] = along[k - 1] if k > 0 else 0.0
        else:
            along[k] = along[k - 1] + moved[3]
            mean, spread, _ = _predicted(means[k - 1], spreads[k - 1], moved, seconds[k], bend)
        if weights[k] > 0.0:
            mean, spread = _claimed(mean, spread, claims[k], noise[k - first] / weights[k])
        means[k], spreads[k] = mean, spread


@compiled
def smooth_backwards(
    known: KeyframeClaims, bend: float, first: int, last: int, cable: CurveStates
) -> None:
    """Smooth `cable` at the keyframes from the one before `last` back to `first`."""
    places, seconds, _, _, _ = known
    _, means, spreads, is_new = cable
    for k in range(min(last, len(places) - 1) - 1, first - 1, -1):
        if is_new[k + 1]:
            continue
        # What was predicted is worked out again: kept, it would be most of what this takes.
        moved = _moved(places[k], places[k + 1], means[k])
        mean, spread, move = _predicted(means[k], spreads[k], moved, seconds[k + 1], bend)
        back = spreads[k] @ move.T @ np.linalg.inv(spread)
        means[k] += back @ (means[k + 1] - mean)
        spread = spreads[k] + back @ (spreads[k + 1] - spread) @ back.T
        spreads[k] = 0.5 * (spread + spread.T)
