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
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.compilation import compiled
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.survey.frame_table import Rows, is_claimed
from cable_tracker.survey.on_disk import Disk, interpolated, running_sum
from cable_tracker.survey.visibility import border_step_of

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
"""So may one whose borders are steps below this share of the dive's usual ones."""

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

    def of_rows(self, part: slice) -> IndexArray:
        """Return for some rows of the table the looks that they belong to, shape (K,); -1: none."""
        return self.of(np.arange(part.start, part.stop))

    def of(self, rows: IndexArray) -> IndexArray:
        """Return the looks that rows (K,) of the table belong to, shape (K,); -1: none."""
        looks = np.searchsorted(self.first, rows, "right") - 1
        return np.where((looks >= 0) & (rows < self.last[looks]), looks, -1)


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


def look_steps(rows: Rows, poses: FloatArray, disk: Disk | None = None) -> Looks:
    """Put frames together into steps of at least `STEP`.

    Parameters
    ----------
    rows : Rows
        Of a `FrameTable`, shape (N,).
    poses : FloatArray
        x, y, yaw of the vehicle in each frame, shape (N, 3); NaN where it is not known.
    disk : Disk or None
        Where the looks go; None: among the temporary files.
    """
    disk = disk or Disk()
    look = filled(rows["look"], disk)

    def look_lines(part: slice) -> FloatArray:
        (x, y, yaw), reach = poses[part].T, look[part]
        return np.column_stack((x + reach * np.cos(yaw), y + reach * np.sin(yaw), yaw))

    places = disk.filled(len(rows), look_lines)
    first, last = _first_and_last(places, disk)
    count = len(first)
    own = disk.filled(count, lambda part: places[first[part]])
    claims, covariances = disk.array((count, 2)), disk.array((count, 3))
    diameters, border_steps = disk.array(count), disk.array(count)
    for part in disk.blocks(count):
        _put_claims(
            rows, places, (first[part], last[part]),
            (claims[part], covariances[part], diameters[part], border_steps[part]),
        )  # fmt: skip
    gaps = disk.filled(count, lambda part: _way_to(own, part))
    breaks = disk.filled(count, lambda part: gaps[part] > LONGEST_STEP, np.bool_)
    breaks[:1] = True
    alone = _alone(_summed(gaps, disk), claims, disk)
    odd, weak = _odd_limits(diameters, disk), _weak_limit(border_steps, disk)

    def doubts(part: slice) -> BoolArray:
        with np.errstate(invalid="ignore"):
            found: BoolArray = odd(diameters[part]) | (border_steps[part] < weak) | alone[part]
        return found

    return Looks(
        own,
        disk.filled(count, lambda part: rows["stamp"][first[part]], np.int64),
        claims,
        covariances,
        disk.filled(count, doubts, np.bool_),
        breaks,
        first,
        last,
    )


def _first_and_last(places: FloatArray, disk: Disk) -> tuple[IndexArray, IndexArray]:
    """Return rows from which, and up to but without which, looks go; places (N, 3)."""
    starts, usable = disk.growing(np.int64), -1
    latest = np.full(2, np.inf)
    for part in disk.blocks(len(places)):
        known = np.flatnonzero(np.isfinite(places[part]).all(axis=1))
        own = places[part][known, :2]
        found = known[_starts(own, latest, STEP)] + part.start
        starts.extend(found)
        if len(found):
            latest = places[found[-1], :2].copy()
        if len(known):
            usable = part.start + int(known[-1])
    first = starts.rows()
    last = disk.array(len(first), np.int64)
    last[:-1], last[-1:] = first[1:], usable + 1
    return first, last


def _put_claims(
    rows: Rows,
    places: FloatArray,
    steps: tuple[IndexArray, IndexArray],
    columns: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
) -> None:
    """Write what each of some steps claims: claims, covariances, diameters, border steps."""
    first, last = steps
    start, end = int(first[0]), int(last[-1])
    rows, places = rows[start:end], places[start:end]
    names = ("aside", "heading", "aside_variance", "aside_heading", "heading_variance")
    table = np.column_stack([rows[name].astype(np.float64) for name in names])
    tracked = is_claimed(rows) & np.isfinite(table).all(axis=1) & np.isfinite(places).all(axis=1)
    clear = border_step_of(rows["profile_score"].astype(np.float32))
    claims, covariances, diameters, border_steps = columns
    for column in columns:
        column[:] = np.nan
    claimed = np.flatnonzero(tracked)
    edges = np.searchsorted(claimed, np.append(first, end) - start)
    for number in np.flatnonzero(np.diff(edges)):
        members = claimed[edges[number] : edges[number + 1]]
        reference = places[first[number] - start]
        seen = _in_frame(reference, places[members], table[members, :2])
        if len(members) == 1:
            claims[number], covariances[number] = seen[0], table[members[0], 2:]
            diameters[number], border_steps[number] = (
                rows["diameter"][members[0]],
                clear[members[0]],
            )
            continue
        claims[number] = np.median(seen, axis=0)
        covariances[number] = table[members, 2:].mean(axis=0)
        diameters[number] = np.median(rows["diameter"][members])
        border_steps[number] = np.median(clear[members])


def _way_to(places: FloatArray, part: slice) -> FloatArray:
    """Return how far it is to each of some places (N, 2 or more) from the one before [m]."""
    some = places[max(part.start - 1, 0) : part.stop, :2]
    steps: FloatArray = np.hypot(*np.diff(some, axis=0, prepend=some[:1]).T)
    return steps[len(steps) - (part.stop - part.start) :]


def _summed(steps: FloatArray, disk: Disk) -> FloatArray:
    """Return the sum of steps (S,) up to each."""
    sums, before = disk.array(len(steps)), 0.0
    for part in disk.blocks(len(steps)):
        sums[part] = running_sum(steps[part], before)
        before = float(sums[part.stop - 1])
    whole: FloatArray = sums
    return whole


def filled(values: FloatArray, disk: Disk) -> FloatArray:
    """Return values (N,) with those between for what is not known."""
    places, known = disk.growing(np.float64), disk.growing(np.float64)
    for part in disk.blocks(len(values)):
        some = values[part]
        there = np.flatnonzero(np.isfinite(some))
        places.extend(there + part.start)
        known.extend(some[there])
    where, what = places.rows(), known.rows()

    def between(part: slice) -> FloatArray:
        if len(where) < 2:
            return np.full(part.stop - part.start, what[0] if len(where) else 0.0)
        return interpolated(np.arange(part.start, part.stop, dtype=float), where, what)

    whole: FloatArray = disk.filled(len(values), between)
    return whole


def _odd_limits(diameters: FloatArray, disk: Disk) -> Callable[[FloatArray], BoolArray]:
    """Return what tells which diameters are out of the ordinary among all (S,) [m]; NaN is not."""
    usual = _usual(diameters, disk)

    def odd(some: FloatArray) -> BoolArray:
        found: BoolArray = np.abs(some - usual) > ODD_DIAMETER * usual
        return found

    return odd


def _weak_limit(border_steps: FloatArray, disk: Disk) -> float:
    """Return below which steps of the borders are far below the usual of all (S,); or NaN."""
    return WEAK_BORDERS * _usual(border_steps, disk)


def _usual(values: FloatArray, disk: Disk) -> float:
    """Return the median of the values (S,) that are known; NaN: none is."""
    if not any(np.isfinite(values[part]).any() for part in disk.blocks(len(values))):
        return math.nan
    return disk.median(values, lambda part: np.isfinite(values[part]))


def _alone(way: FloatArray, claims: FloatArray, disk: Disk) -> BoolArray:
    """Tell which claims (S, 2) are of a short run between silences, shape (S,); none if most are.

    `way` (S,) is how far the look line has gone [m].
    """
    alone: BoolArray = disk.array(len(way), np.bool_)
    runs: list[tuple[int, int, int, float, float]] = []
    for part in disk.blocks(len(way)):
        claimed = np.flatnonzero(np.isfinite(claims[part, 0])) + part.start
        if not len(claimed):
            continue
        edges = np.flatnonzero(np.diff(way[claimed]) > SILENCE) + 1
        for some in np.split(claimed, edges):
            run = (
                int(some[0]),
                int(some[-1]),
                len(some),
                float(way[some[0]]),
                float(way[some[-1]]),
            )
            if runs and not run[3] - runs[-1][4] > SILENCE:
                before = runs.pop()
                run = (before[0], run[1], before[2] + run[2], before[3], run[4])
            runs.append(run)
    short = [run for run in runs if run[4] - run[3] < SHORT_RUN]
    if sum(run[2] for run in short) < 0.5 * sum(run[2] for run in runs):
        for start, end, *_ in short:
            alone[start : end + 1] = np.isfinite(claims[start : end + 1, 0])
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
def _starts(places: FloatArray, before: FloatArray, step: float) -> IndexArray:
    """Return the first of each run of places (N, 2) that are nearer together than a step.

    The run of the place `before` (2,) may go on.
    """
    starts = np.empty(len(places), np.int64)
    x, y = before[0], before[1]
    count = 0
    for k in range(len(places)):
        dx, dy = places[k, 0] - x, places[k, 1] - y
        if dx * dx + dy * dy < step * step:
            continue
        x, y = places[k, 0], places[k, 1]
        starts[count] = k
        count += 1
    return starts[:count]


def smooth(looks: Looks, disk: Disk | None = None, *, way_back: bool = True) -> SmoothedCable:
    """Smooth the claims of a dive in both directions, or only filter them forwards.

    What is found goes to `disk`; None: among the temporary files.
    """
    disk = disk or Disk()
    count = len(looks.stamps)
    cable = SmoothedCable(
        disk.array(count),
        disk.array((count, 3)),
        disk.array((count, 3, 3)),
        # What may be something else has to fit to what the others say, so these come first.
        disk.filled(count, lambda part: np.where(_usual_claims(looks, part), 1.0, 0.0)),
        (1.0, 1.0),
        BEND,
        _pieces(looks.breaks, disk),
    )
    is_new = disk.array(count, np.bool_)
    steps = disk.filled(count, lambda part: _way_to(looks.places, part))
    seconds = disk.filled(count, lambda part: _seconds_to(looks.stamps, part))
    shared = _shared(_summed(steps, disk), looks.claims, disk)
    for _ in range(ROUNDS):
        for part in disk.blocks(count):
            noise = _noise(looks.covariances[part], cable.scales) * shared[part, None]
            _forwards(
                looks.places, seconds, looks.claims, noise, cable.weights, looks.breaks,
                cable.bend, part.start, part.stop, cable.along, cable.states, cable.covariances,
                is_new,
            )  # fmt: skip
        for part in disk.blocks_back(count) if way_back else ():
            _backwards(
                looks.places, seconds, is_new, cable.bend, part.start, part.stop, cable.states,
                cable.covariances,
            )  # fmt: skip
        cable = _weighed(looks, cable, disk)
    return cable


def _usual_claims(looks: Looks, part: slice) -> BoolArray:
    """Tell for some looks whether they have a claim that is surely of the cable."""
    claimed: BoolArray = np.isfinite(looks.claims[part].sum(axis=1))
    return claimed & ~looks.doubtful[part]


def _pieces(breaks: BoolArray, disk: Disk) -> IndexArray:
    """Return the number of the connected piece that each look belongs to, shape (S,)."""
    pieces, before = disk.array(len(breaks), np.int64), -1
    for part in disk.blocks(len(breaks)):
        pieces[part] = before + np.cumsum(breaks[part])
        before = int(pieces[part.stop - 1])
    whole: IndexArray = pieces
    return whole


def _seconds_to(stamps: IndexArray, part: slice) -> FloatArray:
    """Return how long it is to each of some looks from the one before [s]."""
    some = stamps[max(part.start - 1, 0) : part.stop]
    steps: FloatArray = np.diff(some, prepend=some[:1]) / NANOSECONDS
    return steps[len(steps) - (part.stop - part.start) :]


def _weighed(looks: Looks, cable: SmoothedCable, disk: Disk) -> SmoothedCable:
    """Return a smoothed cable with scales and bend as its claims have them, and new weights."""
    count, scales, bend = len(looks.stamps), cable.scales, cable.bend
    squares = disk.filled(count, lambda part: _squares(looks, cable, part))
    misses = np.ones(2)
    if any(_usual_claims(looks, part).any() for part in disk.blocks(count)):
        usual = [
            disk.median(column, lambda part: _usual_claims(looks, part)) for column in squares.T
        ]
        misses = np.sqrt(np.array(usual) / MEDIAN_SQUARE)
        scales, bend = _scaled(scales, misses), _bend(cable, disk)
        misses = np.maximum(misses, 1e-9)
    for part in disk.blocks(count):
        off, plain = _off(looks, cable, part), _noise(looks.covariances[part], cable.scales)
        claimed: BoolArray = np.isfinite(looks.claims[part].sum(axis=1))
        counts = _usual_claims(looks, part) | (claimed & _fits(off, plain, cable.covariances[part]))
        far = (squares[part] / misses**2).sum(axis=1)
        cable.weights[part] = np.where(counts, (DEGREES + 2.0) / (DEGREES + far), 0.0)
    return replace(cable, scales=scales, bend=bend)


def _off(looks: Looks, cable: SmoothedCable, part: slice) -> FloatArray:
    """Return by how much some claims are off the cable, shape (K, 2) [m, rad]."""
    off: FloatArray = looks.claims[part] - cable.states[part, :2]
    return off


def _squares(looks: Looks, cable: SmoothedCable, part: slice) -> FloatArray:
    """Return the same, squared, in variances of the claims."""
    off = _off(looks, cable, part)
    squares: FloatArray = off**2 / _noise(looks.covariances[part], cable.scales)[:, ::2]
    return squares


def _shared(way: FloatArray, claims: FloatArray, disk: Disk) -> FloatArray:
    """Return how many claims share what one would say alone, at each look, shape (S,).

    Parameters
    ----------
    way : FloatArray
        How far the look line has gone, shape (S,) [m].
    claims : FloatArray
        Of the looks, shape (S, 2); NaN without.
    disk : Disk
        Where they are.
    """
    shared: FloatArray = disk.filled(len(way), lambda part: np.ones(part.stop - part.start))
    where = disk.growing(np.int64)
    for part in disk.blocks(len(way)):
        where.extend(np.flatnonzero(np.isfinite(claims[part].sum(axis=1))) + part.start)
    claimed = where.rows()
    last = len(claimed) - 1
    for part in disk.blocks(len(claimed)) if last > 0 else ():
        number = np.arange(part.start, part.stop)
        # The first and the last have a neighbour on one side only, which stands for both.
        before = way[claimed[np.maximum(number, 1)]] - way[claimed[np.maximum(number, 1) - 1]]
        after = (
            way[claimed[np.minimum(number, last - 1) + 1]]
            - way[claimed[np.minimum(number, last - 1)]]
        )
        # Beside a silence the claims on the other side tell how dense they are.
        before, after = (
            np.where(before > CORRELATION, after, before),
            np.where(after > CORRELATION, before, after),
        )
        shared[claimed[part]] = CORRELATION / np.clip((before + after) / 2, STEP, CORRELATION)
    return shared


def _scaled(scales: tuple[float, float], misses: FloatArray) -> tuple[float, float]:
    """Return scales that are corrected by what they have missed, (2,), within limits."""
    place, direction = np.clip(np.array(scales) * misses, LEAST_SCALE, MOST_SCALE).tolist()
    return place, direction


def _bend(cable: SmoothedCable, disk: Disk) -> float:
    """Return the curvature's standard deviation, as expectation and maximisation has it [1/m]."""
    squares = disk.filled(
        len(cable.along),
        lambda part: cable.states[part, 2] ** 2 + cable.covariances[part, 2, 2],
    )
    square = float(np.mean(squares))
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
def _forwards(  # noqa: PLR0917
    places: FloatArray,
    seconds: FloatArray,
    claims: FloatArray,
    noise: FloatArray,
    weights: FloatArray,
    breaks: BoolArray,
    bend: float,
    first: int,
    last: int,
    along: FloatArray,
    means: FloatArray,
    spreads: FloatArray,
    is_new: BoolArray,
) -> None:
    """Filter the looks from `first` up to `last`, into the last four arrays; see `smooth`.

    `noise` has those of these looks; of the other arrays one before the first is read.
    """
    moved = np.zeros(4)
    for k in range(first, last):
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
def _backwards(  # noqa: PLR0917
    places: FloatArray,
    seconds: FloatArray,
    is_new: BoolArray,
    bend: float,
    first: int,
    last: int,
    means: FloatArray,
    spreads: FloatArray,
) -> None:
    """Smooth the looks from the one before `last` back to `first`, in the last two arrays."""
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
