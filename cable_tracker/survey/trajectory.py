"""Trajectory of the vehicle: odometry with its jumps removed."""

from __future__ import annotations

import math
from collections.abc import Set
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray, interpolated
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.survey.frame_table import Rows, Samples
from cable_tracker.survey.memory_mapped import Disk, Unwrapping, surroundings

LONGEST_GAP = 1.0
"""Longest silence of odometry over which poses are interpolated [s]."""

JUMP = 0.5
"""Distance of a pose from the reach of the vehicle that counts as a jump [m]."""

JUMP_TURN = math.radians(20.0)
"""Turn between two poses that counts as a jump [rad]."""

FASTEST, SLOW = 5.0, 0.1
"""Largest speed of a vehicle over a cable, and one that odometry may miss [m/s]."""

MOST_STRAYS = 10
"""Largest number of consecutive readings whose stamps of another time are strays."""

BAD_PLACE = 1e7
"""Largest distance of odometry from its origin [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """A vehicle's trajectory in one frame, without jumps.

    Attributes
    ----------
    stamps : IndexArray
        Shape (N,) [ns].
    poses : FloatArray
        x, y, yaw (unwrapped), shape (N, 3) [m, rad].
    jumps : tuple of int
        Stamps at which odometry began anew or jumped, or its clock did [ns].
    strays : int
        Number of readings with stamps of another time, which do not count.
    joints : tuple of int
        Rows that the trajectory was joined before: how far the vehicle moved since the row before
        is not known.
    """

    stamps: IndexArray
    poses: FloatArray
    jumps: tuple[int, ...] = ()
    strays: int = 0
    joints: tuple[int, ...] = ()

    def at(self, stamps: IndexArray) -> FloatArray:
        """Return x, y, yaw at stamps (M,), shape (M, 3); NaN where odometry was silent.

        Only what lies around these stamps is read.
        """
        count = len(self.stamps)
        if count < 2:
            return np.full((len(stamps), 3), np.nan)
        base, end = self.stamps[0], (self.stamps[-1] - self.stamps[0]) / NANOSECONDS
        around = surroundings(self.stamps, stamps)
        known = self.stamps[around]
        own, asked = (known - base) / NANOSECONDS, (stamps - base) / NANOSECONDS
        found = interpolated(asked, own, self.poses[around])
        after = np.clip(np.searchsorted(known, stamps), 1, len(known) - 1)
        gap = own[after] - own[after - 1]
        outside = (asked < -0.1) | (asked > end + 0.1)
        found[outside | (gap > LONGEST_GAP)] = np.nan
        return found


def joined_trajectory(samples: Samples, disk: Disk) -> Trajectory:
    """Return the trajectory of a vehicle, with the pieces of an odometry that jumps put together.

    Over a jump the vehicle is taken to have gone on as before: how far it moved meanwhile is not
    known, and nothing else is.
    """
    readings, jumps, strays = _in_order(samples, disk)
    if not len(readings):
        return Trajectory(np.zeros(0, np.int64), np.zeros((0, 3)))
    stamps = disk.filled(len(readings), lambda rows: readings["stamp"][rows], np.int64)
    poses = disk.filled(len(readings), lambda rows: readings["pose"][rows])
    if not _states_its_speed(readings, disk):
        for rows in disk.blocks(len(readings)):
            readings["speed"][rows] = FASTEST
    broken: list[int] = []
    for rows in disk.blocks(len(readings), 1):
        broken += _broken(readings[rows.start - 1 : rows.stop], rows.start)
    for start in broken:
        _join_at(poses, start, stamps, disk)
    jumps += [int(stamps[k]) for k in broken]
    return Trajectory(stamps, poses, tuple(sorted(set(jumps))), strays, tuple(broken))


def poses_of_rows(rows: Rows, trajectory: Trajectory, disk: Disk) -> FloatArray:
    """Return x, y, yaw of the vehicle in the frames of a table (N,), shape (N, 3); NaN: not known.

    Where the clock has gone back, a time that comes again is that of two places: it counts as that
    of the first. A time without a place takes none away: the stamp of a single picture may be far
    ahead of all others.
    """
    poses: FloatArray = disk.array((len(rows), 3))
    latest = -(2**62)
    for part in disk.blocks(len(rows)):
        stamps = rows["stamp"][part]
        found = trajectory.at(stamps)
        placed = np.where(np.isfinite(found).all(axis=1), stamps, latest)
        running = np.maximum.accumulate(np.concatenate(([latest], placed)))
        found[stamps < running[:-1]] = np.nan
        poses[part], latest = found, int(running[-1])
    return poses


READING = np.dtype([("stamp", "i8"), ("pose", "f8", (3,)), ("speed", "f8"), ("hidden", "f8")])
"""A reading of odometry: x, y, yaw without jumps by a whole turn [m, rad], speed [m/s], and for how
long the vehicle went on unseen before, as the clock had gone back [s]."""


def _in_order(samples: Samples, disk: Disk) -> tuple[Rows, list[int], int]:
    """Return usable readings in order, where the clock went back [ns], and how many are strays."""
    all_stamps, all_values = samples.arrays()
    readings, jumps, yaws = disk.growing(READING), list[int](), Unwrapping()
    strays = _strays(all_stamps, disk)
    latest: int | None = None
    before = hidden = 0
    for rows in disk.blocks(len(all_stamps)):
        values = all_values[rows]
        usable = np.abs(values[:, :2]).max(axis=1, initial=0.0) < BAD_PLACE
        usable[[k - rows.start for k in strays if rows.start <= k < rows.stop]] = False
        stamps, values = all_stamps[rows][usable], values[usable]
        if not len(stamps):
            continue
        if latest is None:
            latest, before = int(stamps[0]) - 1, int(stamps[0])
        running = np.maximum.accumulate(np.concatenate(([latest], stamps)))
        fresh = stamps > running[:-1]
        back = np.diff(stamps, prepend=before) < -NANOSECONDS
        jumps += running[1:][back].tolist()
        latest, before = int(running[-1]), int(stamps[-1])
        fresh_readings = np.zeros(int(fresh.sum()), READING)
        fresh_readings["stamp"], fresh_readings["speed"] = stamps[fresh], values[fresh, 3]
        fresh_readings["hidden"], hidden = _hidden(running[:-1] - stamps, fresh, hidden)
        fresh_readings["pose"][:, :2] = values[fresh, :2]
        fresh_readings["pose"][:, 2] = yaws.apply(values[fresh, 2])
        readings.extend(fresh_readings)
    return readings.rows(), jumps, len(strays)


def _strays(stamps: IndexArray, disk: Disk) -> list[int]:
    """Return a few readings in a row whose stamps (N,) are of another time than those around."""
    ahead = _ahead(stamps, disk)
    return sorted(ahead | _late(stamps, ahead, disk))


def _ahead(stamps: IndexArray, disk: Disk) -> set[int]:
    """Return a few readings in a row whose stamps (N,) are of a later time than what follows.

    Would they count, all that follow would not.
    """
    strays: set[int] = set()
    for rows in disk.blocks(len(stamps), 1):
        steps = np.diff(stamps[rows.start - 1 : rows.stop])
        for k in (np.flatnonzero(steps < -NANOSECONDS) + rows.start).tolist():
            least = max(k - MOST_STRAYS, 0)
            ahead = stamps[least:k] >= stamps[k]
            own = int(np.argmin(ahead[::-1])) if not ahead.all() else len(ahead)
            if own < MOST_STRAYS:
                strays.update(range(k - own, k))
    return strays


def _late(stamps: IndexArray, ahead: Set[int], disk: Disk) -> set[int]:
    """Return a few readings in a row of an earlier time, after which the stamps (N,) go on.

    They were overtaken on their way. A clock that was set back does not go on at once. `ahead` are
    readings that do not count.
    """
    strays: set[int] = set()
    for rows in disk.blocks(len(stamps), 1):
        steps = np.diff(stamps[rows.start - 1 : rows.stop])
        for k in (np.flatnonzero(steps > NANOSECONDS) + rows.start).tolist():
            before = [i for i in range(max(k - MOST_STRAYS, 0), k) if i not in ahead]
            latest = max(before, key=lambda i: int(stamps[i]), default=k)
            late = [i for i in before if i > latest]
            goes_on = k not in ahead and stamps[k] > stamps[latest]
            if goes_on and all(stamps[i] < stamps[latest] - NANOSECONDS for i in late):
                strays.update(late)
    return strays


def _hidden(back: IndexArray, fresh: BoolArray, before: int) -> tuple[FloatArray, int]:
    """Return by how much the clock had gone back right before each fresh reading (F,) [s].

    `back` (N,) is how far each reading lies before the latest one [ns]; `before`, and what comes
    second, is the most of those since the last fresh one.
    """
    most = np.maximum.reduceat(np.where(fresh, 0, back), np.append(0, np.flatnonzero(fresh)))
    most[0] = max(int(most[0]), before)
    return most[:-1] / NANOSECONDS, int(most[-1])


def _states_its_speed(readings: Rows, disk: Disk) -> bool:
    """Tell whether the speeds of readings (N,) are those of their steps, or at least of half.

    Odometry without a twist says 0.
    """
    moving = too_far = 0
    for rows in disk.blocks(len(readings), 1):
        seconds, steps = _steps(readings[rows.start - 1 : rows.stop])
        speeds = np.maximum(
            readings["speed"][rows], readings["speed"][rows.start - 1 : rows.stop - 1]
        )
        moving += int(np.count_nonzero(steps > SLOW * seconds))
        too_far += int(np.count_nonzero(steps > (2.0 * speeds + SLOW) * seconds))
    return 2 * too_far <= moving


def _steps(readings: Rows) -> tuple[FloatArray, FloatArray]:
    """Return times between readings (N,), and distances, shapes (N - 1,) [s, m]."""
    seconds = np.maximum(np.diff(readings["stamp"]) / NANOSECONDS, 0.0) + readings["hidden"][1:]
    return seconds, np.hypot(*np.diff(readings["pose"][:, :2], axis=0).T)


def _broken(readings: Rows, first: int) -> list[int]:
    """Return where readings (N,) jump, the second of which has the number `first`."""
    seconds, steps = _steps(readings)
    speeds = np.maximum(readings["speed"][1:], readings["speed"][:-1])
    reach = JUMP + seconds * np.minimum(2.0 * speeds + SLOW, FASTEST)
    turns = np.abs(np.diff(readings["pose"][:, 2]))
    jumps = (steps > reach) | (turns > JUMP_TURN + 2.0 * seconds)
    return [first + int(k) for k in np.flatnonzero(jumps)]


def _join_at(poses: FloatArray, start: int, stamps: IndexArray, disk: Disk) -> None:
    """Shift the poses from a row on so that the trajectory continues as before it."""
    before = max(start - 2, 0)
    step = max(float(stamps[start - 1] - stamps[before]), 1.0)
    share = min(float(stamps[start] - stamps[start - 1]) / step, 3.0)
    expected = poses[start - 1] + share * (poses[start - 1] - poses[before])
    if start - 1 == before:
        expected = poses[start - 1].copy()
    origin = poses[start].copy()
    turn = float(expected[2] - origin[2])
    for rows in disk.blocks(len(poses), start):
        poses[rows, :2] = turned(poses[rows, :2] - origin[:2], turn) + expected[:2]
        poses[rows, 2] += turn


def turned(points: FloatArray, turn: float) -> FloatArray:
    """Return points (N, 2) turned by an angle to the left [rad].

    Written out: the last bit of a product of matrices depends on how many rows they have.
    """
    cos, sin = math.cos(turn), math.sin(turn)
    x, y = points.T
    return np.column_stack((x * cos - y * sin, x * sin + y * cos))
