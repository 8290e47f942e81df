"""The way backwards: a cable lies still, so that what comes later tells of what was before.

Where the camera looks, the cable has a place beside the look line, a direction and a curvature.
From one look to the next the vehicle moves as odometry has it, and the cable goes on as a curve
whose curvature forgets itself over some metres. Each tracked frame measures place and direction.
Their errors are far from independent: consecutive pictures show nearly the same piece of cable,
with the same growth on it. They count together as about one measurement for each `CORRELATION` of
way.

Forwards this is a Kalman filter, backwards the smoother of Rauch, Tung and Striebel. Claims that do
not fit to what lies before and behind lose their weight, as with Student's t.

Gaussians instead of smoothed particles: by the time that a cable is claimed the tracker has settled
on one place, what is smoothed lies in a plane in metres, and stretches of a hundred metres without
a claim are bridged with a covariance, where particles would have died out.

References
----------
H. E. Rauch, F. Tung and C. T. Striebel (1965), "Maximum likelihood estimates of linear dynamic
systems".
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.compilation import compiled
from cable_tracker.survey.frame_table import Rows, is_claimed
from cable_tracker.survey.visibility import clearness_of

STEP = 0.05
"""Looks that are nearer together than this are taken as one [m]."""

LONGEST_STEP = 2.0
"""Looks that are farther apart do not belong together [m]."""

CORRELATION = 0.8
"""Way over which the errors of claims are alike [m]."""

BEND, BEND_LENGTH = 0.05, 6.0
"""Standard deviation of the curvature that is begun with [1/m], and way over which it forgets
itself [m]."""

LEAST_BEND, MOST_BEND = 0.01, 0.2
"""Within these limits the smoothed claims say how much the cable of a dive bends [1/m]."""

ROUGHNESS = 1e-4
"""What odometry adds to the variance of the place, per second [m²/s]."""

YAW_SIGMA = math.radians(0.2)
"""Doubt about each yaw of odometry [rad]."""

FLOOR = 0.004
"""No claim is taken to be better than this [m]."""

HEADING_FLOOR = math.radians(0.5)
"""The same of its direction; a straight line in a picture of a bent cable [rad]."""

DEGREES = 4.0
"""Degrees of freedom of Student's t."""

MEDIAN_SQUARE = 0.455
"""Median of the square of a standard normal variable."""

ROUNDS = 4
LEAST_SCALE, MOST_SCALE = 0.3, 8.0
"""By how much the tracker's standard deviations may be corrected at most, by what they miss."""

ODD_DIAMETER = 0.25
"""A claim whose diameter is off the dive's usual one by this share may be of something else."""

WEAK_BORDERS = 0.6
"""So may one whose borders are seen less clearly than this share of the dive's usual clearness."""

SILENCE, SHORT_RUN = 1.0, 2.0
"""So may claims over a shorter way with silence on both sides of them [m]: a cable that comes out
of the sand is mostly seen for longer."""

FITTING, SURE_ENOUGH = 3.0, 0.25
"""What may be of something else counts where it fits to what the other claims say within so many
standard deviations, and they know the place so well [m]."""

FIRST = (4.0, math.radians(30.0) ** 2)
"""Variances of place and direction where nothing is known [m², rad²]."""


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """Where the camera looked, step by step, and what it claimed.

    Attributes
    ----------
    places : FloatArray
        Where the look line is in the dive's frame, and its direction, shape (S, 3) [m, rad].
    stamps : FloatArray
        Int64, shape (S,) [ns].
    claims : FloatArray
        Place beside the look line and direction from it, shape (S, 2) [m, rad]; NaN without.
    covariances : FloatArray
        Of place, both, direction, shape (S, 3).
    doubtful : BoolArray
        Whether a claim may be of something else than the cable, shape (S,): its diameter is out of
        the ordinary, its borders are hardly seen, or it is one of a few between silences.
    breaks : BoolArray
        Whether a step does not go on from the one before, shape (S,).
    first, last : FloatArray
        Rows of the table that a step stands for, shape (S,): from, and up to but without.
    """

    places: FloatArray
    stamps: IndexArray
    claims: FloatArray
    covariances: FloatArray
    doubtful: BoolArray
    breaks: BoolArray
    first: IndexArray
    last: IndexArray


@dataclass(frozen=True, slots=True, eq=False)
class SmoothedCable:
    """The cable at each look.

    Attributes
    ----------
    along : FloatArray
        Way along the cable since the first look, shape (S,) [m]; smaller where the vehicle went
        back.
    states : FloatArray
        Place beside the look line, direction from it, curvature, shape (S, 3) [m, rad, 1/m].
    covariances : FloatArray
        Shape (S, 3, 3).
    weights : FloatArray
        How much each claim counted, 0 to about 1, shape (S,); 0 without a claim, or for one that is
        of something else.
    scales : (float, float)
        By how much the tracker's standard deviations of place and direction were too small.
    bend : float
        Standard deviation of the cable's curvature [1/m].
    piece : FloatArray
        Number of the connected piece that a look belongs to, shape (S,).
    """

    along: FloatArray
    states: FloatArray
    covariances: FloatArray
    weights: FloatArray
    scales: tuple[float, float]
    bend: float
    piece: IndexArray


def look_steps(rows: Rows, poses: FloatArray) -> Looks:
    """Put frames together into steps of at least `STEP`.

    Parameters
    ----------
    rows : Rows
        Of a `FrameTable`, shape (N,).
    poses : FloatArray
        x, y, yaw of the vehicle in each frame, shape (N, 3); NaN where it is not known.
    """
    look = filled(rows["look"])
    yaw = poses[:, 2]
    places = np.column_stack(
        (poses[:, 0] + look * np.cos(yaw), poses[:, 1] + look * np.sin(yaw), yaw)
    )
    usable = np.flatnonzero(np.isfinite(places).all(axis=1))
    starts = _starts(places[usable, :2], STEP)
    count = len(starts)
    ends = np.append(starts[1:], len(usable))
    claims, covariances = np.full((count, 2), np.nan), np.full((count, 3), np.nan)
    columns = ("aside", "heading", "aside_variance", "aside_heading", "heading_variance")
    table = np.column_stack([rows[name].astype(np.float64) for name in columns])
    tracked = is_claimed(rows) & np.isfinite(table).all(axis=1)
    diameters, clearness = np.full(count, np.nan), np.full(count, np.nan)
    clear = clearness_of(rows["profile_score"].astype(np.float32))
    for number, (start, end) in enumerate(zip(starts, ends, strict=True)):
        members = usable[start:end]
        members = members[tracked[members]]
        if not len(members):
            continue
        seen = _in_frame(places[usable[start]], places[members], table[members, :2])
        claims[number] = np.median(seen, axis=0)
        covariances[number] = table[members, 2:].mean(axis=0)
        diameters[number] = np.median(rows["diameter"][members])
        clearness[number] = np.median(clear[members])
    own = places[usable[starts]]
    gaps = np.hypot(*np.diff(own[:, :2], axis=0, prepend=own[:1, :2]).T)
    breaks = gaps > LONGEST_STEP
    if count:
        breaks[0] = True
    rows_at = np.append(usable, usable[-1] + 1 if len(usable) else 0)
    return Looks(
        own,
        rows["stamp"][usable[starts]],
        claims,
        covariances,
        _odd(diameters) | _weak(clearness) | _alone(np.cumsum(gaps), np.isfinite(claims[:, 0])),
        breaks,
        usable[starts],
        rows_at[ends],
    )


def filled(values: FloatArray) -> FloatArray:
    """Return values (N,) with those between for what is not known."""
    known = np.flatnonzero(np.isfinite(values))
    if not len(known):
        return np.zeros(len(values))
    return np.asarray(np.interp(np.arange(len(values)), known, values[known]))


def _odd(diameters: FloatArray) -> BoolArray:
    """Tell which diameters (S,) [m] are out of the ordinary; NaN is not."""
    known = np.isfinite(diameters)
    if not known.any():
        return np.zeros(len(diameters), bool)
    usual = float(np.median(diameters[known]))
    with np.errstate(invalid="ignore"):
        odd: BoolArray = np.abs(diameters - usual) > ODD_DIAMETER * usual
    return odd


def _weak(clearness: FloatArray) -> BoolArray:
    """Tell where borders are seen far less clearly, shape (S,), than usual; NaN is not."""
    known = np.isfinite(clearness)
    if not known.any():
        return np.zeros(len(clearness), bool)
    with np.errstate(invalid="ignore"):
        weak: BoolArray = clearness < WEAK_BORDERS * float(np.median(clearness[known]))
    return weak


def _alone(way: FloatArray, claimed: BoolArray) -> BoolArray:
    """Tell which claims are of a short run between silences, shape (S,); none if most are."""
    alone = np.zeros(len(way), bool)
    places = way[claimed]
    if not len(places):
        return alone
    run = np.cumsum(np.diff(places, prepend=places[0]) > SILENCE)
    first = np.searchsorted(run, np.arange(run[-1] + 1))
    last = np.append(first[1:], len(run)) - 1
    short = (places[last] - places[first] < SHORT_RUN)[run]
    alone[claimed] = short & (short.mean() < 0.5)
    return alone


def _in_frame(reference: FloatArray, places: FloatArray, claims: FloatArray) -> FloatArray:
    """Return claims (K, 2) made at places (K, 3) as seen from one place (3,), shape (K, 2)."""
    turn = places[:, 2] - reference[2]
    cos, sin = math.cos(reference[2]), math.sin(reference[2])
    apart = places[:, :2] - reference[:2]
    x = apart[:, 0] * cos + apart[:, 1] * sin - claims[:, 0] * np.sin(turn)
    y = -apart[:, 0] * sin + apart[:, 1] * cos + claims[:, 0] * np.cos(turn)
    heading = claims[:, 1] + turn
    return np.column_stack((y - x * np.tan(heading), heading))


@compiled
def _starts(places: FloatArray, step: float) -> IndexArray:
    """Return the first of each run of places (N, 2) that are nearer together than a step."""
    starts = np.empty(len(places), np.int64)
    count = 0
    for k in range(len(places)):
        if count > 0:
            last = starts[count - 1]
            dx, dy = places[k, 0] - places[last, 0], places[k, 1] - places[last, 1]
            if dx * dx + dy * dy < step * step:
                continue
        starts[count] = k
        count += 1
    return starts[:count]


def smooth(looks: Looks, *, way_back: bool = True) -> SmoothedCable:
    """Smooth the claims of a dive in both directions, or only filter them forwards."""
    claimed: BoolArray = np.isfinite(looks.claims.sum(axis=1))
    # What may be something else has to fit to what the others say, so these come first.
    weights = np.where(claimed & ~looks.doubtful, 1.0, 0.0)
    scales, bend = (1.0, 1.0), BEND
    count = len(looks.stamps)
    # All rounds write into the same arrays: a dive has as many looks as it is long.
    along, states, covariances = np.zeros(count), np.zeros((count, 3)), np.zeros((count, 3, 3))
    steps = np.hypot(*np.diff(looks.places[:, :2], axis=0, prepend=looks.places[:1, :2]).T)
    seconds = np.diff(looks.stamps, prepend=looks.stamps[:1]) / 1e9
    shared = _shared(np.cumsum(steps), claimed)
    for _ in range(ROUNDS):
        noise = _noise(looks.covariances, scales) * shared[:, None]
        _both_ways(
            looks.places, seconds, looks.claims, noise, weights, looks.breaks, bend, way_back,
            along, states, covariances,
        )  # fmt: skip
        del noise
        off = looks.claims - states[:, :2]
        plain = _noise(looks.covariances, scales)
        squares = off**2 / plain[:, ::2]
        usual = claimed & ~looks.doubtful
        if usual.any():
            misses = np.sqrt(np.median(squares[usual], axis=0) / MEDIAN_SQUARE)
            scales = _scaled(scales, misses)
            squares = squares / np.maximum(misses, 1e-9) ** 2
            bend = _bend(states, covariances)
        counts = usual | (claimed & _fits(off, plain, covariances))
        far = squares.sum(axis=1)
        weights = np.where(counts, (DEGREES + 2.0) / (DEGREES + far), 0.0)
    piece = np.cumsum(looks.breaks).astype(np.int64) - 1
    return SmoothedCable(along, states, covariances, weights, scales, bend, piece)


def _shared(way: FloatArray, claimed: BoolArray) -> FloatArray:
    """Return how many claims share what one would say alone, at each look, shape (S,).

    Parameters
    ----------
    way : FloatArray
        How far the look line has gone, shape (S,) [m].
    claimed : BoolArray
        Where there are claims, shape (S,).
    """
    shared = np.ones(len(way))
    gaps = np.diff(way[claimed])
    if len(gaps):
        before, after = np.append(gaps[:1], gaps), np.append(gaps, gaps[-1:])
        # Beside a silence the claims on the other side tell how dense they are.
        before, after = (
            np.where(before > CORRELATION, after, before),
            np.where(after > CORRELATION, before, after),
        )
        shared[claimed] = CORRELATION / np.clip((before + after) / 2, STEP, CORRELATION)
    return shared


def _scaled(scales: tuple[float, float], misses: FloatArray) -> tuple[float, float]:
    """Return scales that are corrected by what they have missed, (2,), within limits."""
    place, direction = np.clip(np.array(scales) * misses, LEAST_SCALE, MOST_SCALE).tolist()
    return place, direction


def _bend(states: FloatArray, covariances: FloatArray) -> float:
    """Return the curvature's standard deviation, as expectation and maximisation has it [1/m]."""
    square = float(np.mean(states[:, 2] ** 2 + covariances[:, 2, 2]))
    return min(max(math.sqrt(square), LEAST_BEND), MOST_BEND)


def _fits(off: FloatArray, noise: FloatArray, covariances: FloatArray) -> BoolArray:
    """Tell which claims lie where the cable is known to be, shape (S,)."""
    known = covariances[:, 0, 0] < SURE_ENOUGH**2
    near = off[:, 0] ** 2 < FITTING**2 * (noise[:, 0] + covariances[:, 0, 0])
    along = off[:, 1] ** 2 < FITTING**2 * (noise[:, 2] + covariances[:, 1, 1])
    fits: BoolArray = known & near & along
    return fits


def _noise(covariances: FloatArray, scales: tuple[float, float]) -> FloatArray:
    place, direction = scales
    noise: FloatArray = covariances * [place**2, place * direction, direction**2]
    noise[:, 0] += FLOOR**2
    noise[:, 2] += HEADING_FLOOR**2 + YAW_SIGMA**2
    return noise


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
    if abs(slope) < 0.2:
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
def _both_ways(  # noqa: PLR0917
    places: FloatArray,
    seconds: FloatArray,
    claims: FloatArray,
    noise: FloatArray,
    weights: FloatArray,
    breaks: BoolArray,
    bend: float,
    way_back: bool,
    along: FloatArray,
    means: FloatArray,
    spreads: FloatArray,
) -> None:
    """Filter forwards and smooth backwards, into the last three arrays; see `smooth`."""
    count = len(places)
    is_new = breaks.copy()
    mean, spread = np.zeros(3), np.zeros((3, 3))
    moved = np.zeros(4)
    for k in range(count):
        if not is_new[k]:
            moved = _moved(places[k - 1], places[k], mean)
            is_new[k] = not np.isfinite(moved[3])
        if is_new[k]:
            mean, spread = np.zeros(3), np.diag(np.array((*FIRST, bend * bend)))
            along[k] = along[k - 1] if k > 0 else 0.0
        else:
            along[k] = along[k - 1] + moved[3]
            mean, spread, _ = _predicted(mean, spread, moved, seconds[k], bend)
        if weights[k] > 0.0:
            mean, spread = _claimed(mean, spread, claims[k], noise[k] / weights[k])
        means[k], spreads[k] = mean, spread
    for k in range(count - 2, -1, -1):
        if is_new[k + 1] or not way_back:
            continue
        # What was predicted is worked out again: kept, it would be most of what this takes.
        moved = _moved(places[k], places[k + 1], means[k])
        mean, spread, move = _predicted(means[k], spreads[k], moved, seconds[k + 1], bend)
        back = spreads[k] @ move.T @ np.linalg.inv(spread)
        means[k] += back @ (means[k + 1] - mean)
        spread = spreads[k] + back @ (spreads[k + 1] - spread) @ back.T
        spreads[k] = 0.5 * (spread + spread.T)
