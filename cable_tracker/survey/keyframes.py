"""Frames of a dive grouped into keyframes: position of the look line, and claim of the cable."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.compilation import compiled
from cable_tracker.survey.frame_table import Rows, is_claimed
from cable_tracker.survey.memory_mapped import Disk, interpolated_locally, running_sum
from cable_tracker.survey.picture_measurements import border_step_of

LEAST_SPACING = 0.05
"""Smallest distance between keyframes; frames that are nearer together become one [m]."""

MOST_SPACING = 2.0
"""Largest distance between consecutive keyframes of a connected piece [m]."""

ODD_DIAMETER = 0.25
"""Deviation of an odd diameter from the dive's usual one, as a share; a claim with such a diameter
may be of something else."""

WEAK_BORDERS = 0.6
"""Border steps of a weak claim as a share of the dive's usual ones; a claim below it may be of
something else."""

SILENCE, SHORT_RUN = 1.0, 2.0
"""Way without claims, and length of a short run of claims between two such ways, which may be of
something else [m]: a cable that comes out of the sand is mostly seen for longer."""


class Keyframes(NamedTuple):
    """S keyframes: pose of the look line and claim of the cable at each.

    Attributes
    ----------
    look_lines : FloatArray
        Position and direction of the look line in the dive's frame, shape (S, 3) [m, rad].
    stamps : IndexArray
        Shape (S,) [ns].
    claims : FloatArray
        Place beside the look line and direction from it, shape (S, 2) [m, rad]; NaN without.
    covariances : FloatArray
        Variance of place, covariance, variance of direction, shape (S, 3).
    doubtful : BoolArray
        Whether a claim may be of something else than the cable, shape (S,): its diameter is out of
        the ordinary, its borders are hardly seen, or it is one of a few between silences.
    breaks : BoolArray
        Whether a keyframe does not go on from the one before, shape (S,).
    first, last : IndexArray
        Rows of the table that a keyframe stands for, shape (S,): from, and up to but without.
        Those between two keyframes have no place.
    """

    look_lines: FloatArray
    stamps: IndexArray
    claims: FloatArray
    covariances: FloatArray
    doubtful: BoolArray
    breaks: BoolArray
    first: IndexArray
    last: IndexArray

    def of_rows(self, part: slice) -> IndexArray:
        """Return the keyframes that a slice of K table rows belongs to, shape (K,); -1: none."""
        return self.of(np.arange(part.start, part.stop))

    def of(self, rows: IndexArray) -> IndexArray:
        """Return the keyframes that rows (K,) of the table belong to, shape (K,); -1: none."""
        keyframes = np.searchsorted(self.first, rows, "right") - 1
        return np.where((keyframes >= 0) & (rows < self.last[keyframes]), keyframes, -1)


def make_keyframes(rows: Rows, poses: FloatArray, disk: Disk) -> Keyframes:
    """Put frames together into keyframes at least `LEAST_SPACING` apart.

    Parameters
    ----------
    rows : Rows
        Rows of a `FrameTable`, shape (N,).
    poses : FloatArray
        x, y, yaw of the vehicle in each frame, shape (N, 3); NaN where it is not known.
    disk : Disk
        Allocator of the keyframes' arrays.
    """
    look = filled(rows["look"], disk)

    def look_lines_at(part: slice) -> FloatArray:
        (x, y, yaw), reach = poses[part].T, look[part]
        return np.column_stack((x + reach * np.cos(yaw), y + reach * np.sin(yaw), yaw))

    look_lines = disk.filled(len(rows), look_lines_at)
    first, last = _first_and_last(look_lines, disk)
    count = len(first)
    own = disk.filled(count, lambda part: look_lines[first[part]])
    claims, covariances = disk.array((count, 2)), disk.array((count, 3))
    diameters, border_steps = disk.array(count), disk.array(count)
    for part in disk.blocks(count):
        _write_claims(
            rows, look_lines, (first[part], last[part]),
            (claims[part], covariances[part], diameters[part], border_steps[part]),
        )  # fmt: skip
    gaps = disk.filled(count, lambda part: step_lengths(own, part))
    breaks = disk.filled(count, lambda part: gaps[part] > MOST_SPACING, np.bool_)
    breaks[:1] = True
    isolated = _isolated_claims(summed(gaps, disk), claims, disk)
    return Keyframes(
        own,
        disk.filled(count, lambda part: rows["stamp"][first[part]], np.int64),
        claims,
        covariances,
        _doubtful_claims(diameters, border_steps, isolated, disk),
        breaks,
        first,
        last,
    )


def _doubtful_claims(
    diameters: FloatArray, border_steps: FloatArray, isolated: BoolArray, disk: Disk
) -> BoolArray:
    """Tell which claims may be of something else than the cable; all arrays (S,)."""
    usual_diameter, usual_step = _usual(diameters, disk), _usual(border_steps, disk)

    def doubtful(part: slice) -> BoolArray:
        with np.errstate(invalid="ignore"):
            odd = np.abs(diameters[part] - usual_diameter) > ODD_DIAMETER * usual_diameter
            weak = border_steps[part] < WEAK_BORDERS * usual_step
        found: BoolArray = odd | weak | isolated[part]
        return found

    whole: BoolArray = disk.filled(len(diameters), doubtful, np.bool_)
    return whole


def _first_and_last(look_lines: FloatArray, disk: Disk) -> tuple[IndexArray, IndexArray]:
    """Return rows from which, and up to but without which, keyframes go; look_lines (N, 3).

    What was seen after the last row with a place, as while odometry is silent, is of none.
    """
    starts, ends, usable = disk.growing(np.int64), disk.growing(np.int64), -1
    latest = np.full(2, np.inf)
    for part in disk.blocks(len(look_lines)):
        known = np.flatnonzero(np.isfinite(look_lines[part]).all(axis=1))
        found = _starts(look_lines[part][known, :2], latest, LEAST_SPACING)
        rows = known + part.start
        starts.extend(rows[found])
        ends.extend(np.append(usable, rows)[found] + 1)
        if len(found):
            latest = look_lines[rows[found[-1]], :2].copy()
        if len(rows):
            usable = int(rows[-1])
    first = starts.rows()
    last = disk.array(len(first), np.int64)
    # Each but the first begins after the end of the one before.
    last[:-1], last[-1:] = ends.rows()[1:], usable + 1
    return first, last


def _write_claims(
    rows: Rows,
    look_lines: FloatArray,
    bounds: tuple[IndexArray, IndexArray],
    columns: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
) -> None:
    """Write claims, covariances, diameters and border steps of some keyframes.

    `bounds` are the rows that each is made of: the first, and the one after the last.
    """
    first, last = bounds
    start, end = int(first[0]), int(last[-1])
    rows, look_lines = rows[start:end], look_lines[start:end]
    names = ("aside", "heading", "aside_variance", "aside_heading", "heading_variance")
    table = np.column_stack([rows[name].astype(np.float64) for name in names])
    tracked = (
        is_claimed(rows) & np.isfinite(table).all(axis=1) & np.isfinite(look_lines).all(axis=1)
    )
    clear = border_step_of(rows["profile_score"].astype(np.float32))
    claims, covariances, diameters, border_steps = columns
    for column in columns:
        column[:] = np.nan
    claimed = np.flatnonzero(tracked)
    edges = np.searchsorted(claimed, np.append(first, end) - start)
    for number in np.flatnonzero(np.diff(edges)):
        members = claimed[edges[number] : edges[number + 1]]
        reference = look_lines[first[number] - start]
        seen = _in_frame(reference, look_lines[members], table[members, :2])
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


def step_lengths(points: FloatArray, part: slice) -> FloatArray:
    """Return how far it is to each of some points (N, 2 or more) from the one before [m]."""
    some = points[max(part.start - 1, 0) : part.stop, :2]
    steps: FloatArray = np.hypot(*np.diff(some, axis=0, prepend=some[:1]).T)
    return steps[len(steps) - (part.stop - part.start) :]


def summed(steps: FloatArray, disk: Disk) -> FloatArray:
    """Return the sum of steps (S,) up to each."""
    sums, before = disk.array(len(steps)), 0.0
    for part in disk.blocks(len(steps)):
        sums[part] = running_sum(steps[part], before)
        before = float(sums[part.stop - 1])
    whole: FloatArray = sums
    return whole


def filled(values: FloatArray, disk: Disk) -> FloatArray:
    """Return values (N,) with those between for what is not known."""
    indices, known = disk.growing(np.float64), disk.growing(np.float64)
    for part in disk.blocks(len(values)):
        some = values[part]
        there = np.flatnonzero(np.isfinite(some))
        indices.extend(there + part.start)
        known.extend(some[there])
    where, what = indices.rows(), known.rows()

    def between(part: slice) -> FloatArray:
        if len(where) < 2:
            return np.full(part.stop - part.start, what[0] if len(where) else 0.0)
        return interpolated_locally(np.arange(part.start, part.stop, dtype=float), where, what)

    whole: FloatArray = disk.filled(len(values), between)
    return whole


def _usual(values: FloatArray, disk: Disk) -> float:
    """Return the median of the values (S,) that are known; NaN: none is."""
    if not any(np.isfinite(values[part]).any() for part in disk.blocks(len(values))):
        return math.nan
    return disk.median(values, lambda part: np.isfinite(values[part]))


def _isolated_claims(travelled: FloatArray, claims: FloatArray, disk: Disk) -> BoolArray:
    """Tell which claims (S, 2) are of a short run between silences, shape (S,); none if most are.

    `travelled` (S,) is the distance that the look line has travelled [m].
    """
    isolated: BoolArray = disk.array(len(travelled), np.bool_)
    runs: list[tuple[int, int, int, float, float]] = []
    for part in disk.blocks(len(travelled)):
        claimed = np.flatnonzero(np.isfinite(claims[part, 0])) + part.start
        if not len(claimed):
            continue
        edges = np.flatnonzero(np.diff(travelled[claimed]) > SILENCE) + 1
        for some in np.split(claimed, edges):
            run = (
                int(some[0]),
                int(some[-1]),
                len(some),
                float(travelled[some[0]]),
                float(travelled[some[-1]]),
            )
            if runs and not run[3] - runs[-1][4] > SILENCE:
                before = runs.pop()
                run = (before[0], run[1], before[2] + run[2], before[3], run[4])
            runs.append(run)
    short = [run for run in runs if run[4] - run[3] < SHORT_RUN]
    if sum(run[2] for run in short) < 0.5 * sum(run[2] for run in runs):
        for start, end, *_ in short:
            isolated[start : end + 1] = np.isfinite(claims[start : end + 1, 0])
    return isolated


def _in_frame(reference: FloatArray, look_lines: FloatArray, claims: FloatArray) -> FloatArray:
    """Return claims (K, 2) at look lines (K, 3) as seen from one look line (3,), shape (K, 2)."""
    turn = look_lines[:, 2] - reference[2]
    cos, sin = math.cos(reference[2]), math.sin(reference[2])
    apart = look_lines[:, :2] - reference[:2]
    x = apart[:, 0] * cos + apart[:, 1] * sin - claims[:, 0] * np.sin(turn)
    y = -apart[:, 0] * sin + apart[:, 1] * cos + claims[:, 0] * np.cos(turn)
    heading = claims[:, 1] + turn
    return np.column_stack((y - x * np.tan(heading), heading))


@compiled
def _starts(points: FloatArray, before: FloatArray, spacing: float) -> IndexArray:
    """Return the first of each run of points (N, 2) that are nearer together than a spacing.

    The run of the point `before` (2,) may go on.
    """
    starts = np.empty(len(points), np.int64)
    x, y = before[0], before[1]
    count = 0
    for k in range(len(points)):
        dx, dy = points[k, 0] - x, points[k, 1] - y
        if dx * dx + dy * dy < spacing * spacing:
            continue
        x, y = points[k, 0], points[k, 1]
        starts[count] = k
        count += 1
    return starts[:count]
