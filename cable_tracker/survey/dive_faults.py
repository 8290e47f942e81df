"""Faults in the data of a dive: reasons for a missing route, or for gaps in one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.survey.forward_pass import ForwardDive
from cable_tracker.survey.frame_table import REFUSED, TRACKING
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.trajectory import LONGEST_GAP, Trajectory
from cable_tracker.tracking import succession


@dataclass(slots=True)
class CountedRows:
    """Counts of the rows of a dive.

    Attributes
    ----------
    tracked, in_metres, placed, placed_partly : int
        Number of rows in which the cable is claimed, is known in metres, and the vehicle's pose is
        known, of all and of a part.
    claims_in_metres : int
        Number of claims that are known in metres.
    refused : int
        Number of pictures that could not be decoded, or not be tracked.
    earliest, latest : int
        Least and largest stamp of the pictures [ns].
    back, ahead : float
        Least and largest step from one picture to the next, as far as beyond 0 [s].
    seconds : float
        Length of the recording, without pauses and jumps of the clock [s].
    reasons : ndarray
        Number of claims without metres, by the number of the reason, shape (R,).
    """

    reasons: IndexArray
    tracked: int = 0
    in_metres: int = 0
    claims_in_metres: int = 0
    placed: int = 0
    placed_partly: int = 0
    refused: int = 0
    earliest: int = 2**62
    latest: int = -(2**62)
    back: float = 0.0
    ahead: float = 0.0
    seconds: float = 0.0


def count_rows(dive: ForwardDive, poses: FloatArray, maximum_gap: float) -> CountedRows:
    """Go through the rows of a dive, whose vehicle had poses (N, 3).

    After a pause longer than `maximum_gap` [s], a parameter of the tracker, it has started anew.
    """
    rows, kinds = dive.table.rows, len(dive.table.reasons)
    found = CountedRows(np.zeros(kinds, np.int64))
    before = rows["stamp"][:1]
    for part in dive.disk.blocks(len(rows)):
        some, known = rows[part], np.isfinite(poses[part])
        claimed = some["status"] == TRACKING
        found.tracked += int(claimed.sum())
        found.refused += int((some["status"] == REFUSED).sum())
        in_metres = np.isfinite(some["aside"])
        found.in_metres += int(in_metres.sum())
        found.claims_in_metres += int((in_metres & claimed).sum())
        found.placed += int(known.all(axis=1).sum())
        found.placed_partly += int(known.any(axis=1).sum())
        found.earliest = min(found.earliest, int(some["stamp"].min()))
        found.latest = max(found.latest, int(some["stamp"].max()))
        steps = np.diff(some["stamp"], prepend=before) / NANOSECONDS
        found.back = min(found.back, float(steps.min()))
        found.ahead = max(found.ahead, float(steps.max()))
        found.seconds += float(steps[(steps >= 0.0) & (steps <= maximum_gap)].sum())
        found.reasons += np.bincount(some["reason"][claimed], minlength=kinds)
        before = some["stamp"][-1:].copy()
    return found


def find_faults(
    dive: ForwardDive, trajectory: Trajectory, counted: CountedRows, maximum_gap: float
) -> list[str]:
    """Say why there is no route, or why it has gaps; `maximum_gap` [s] as for `count_rows`."""
    of_odometry = [
        *_reason_for_gaps(dive, trajectory, counted),
        *_faults_of_odometry(dive, trajectory),
    ]
    of_pictures = _faults_of_pictures(len(dive.table.rows), counted, maximum_gap)
    return of_odometry + of_pictures + _missing_metres(counted, dive.table.reasons)


def _reason_for_gaps(dive: ForwardDive, trajectory: Trajectory, counted: CountedRows) -> list[str]:
    """Say why the vehicle's place is not known in all frames: one reason, or none."""
    rows = dive.table.rows
    if len(trajectory.stamps) < 2:
        what = "a single reading of odometry" if len(trajectory.stamps) else "no odometry"
        return [f"there is {what}: the cable is known in pixels only, and has no route"]
    if not counted.placed_partly and not _overlap_in_time(trajectory, counted):
        apart = abs(float(rows["stamp"][0] - trajectory.stamps[0])) / NANOSECONDS
        return [
            f"no odometry of the pictures' time: their clocks are {apart:.0f} s apart;"
            " synchronise them"
        ]
    if not counted.placed_partly and (pause := _usual_pause(trajectory, dive.disk)) > LONGEST_GAP:
        return [
            f"odometry is too slow: {pause:.1f} s from one reading to the next; publish it"
            f" every {LONGEST_GAP:g} s or more often"
        ]
    if counted.placed < len(rows):
        share = (len(rows) - counted.placed) / len(rows)
        said = f"{share:.0%}" if share >= 0.01 else "less than 1%"
        return [f"odometry was silent, or on another clock, in {said} of the frames"]
    return []


def _faults_of_odometry(dive: ForwardDive, trajectory: Trajectory) -> list[str]:
    """Say which readings of odometry do not count, or do not go on from those before."""
    notes = []
    if trajectory.jumps:
        notes.append(
            f"odometry restarted or jumped {len(trajectory.jumps)} times; the trajectory was joined"
        )
    if trajectory.strays:
        notes.append(
            f"readings of odometry with stamps of another time are ignored: {trajectory.strays}"
        )
    if dive.unusable_poses:
        notes.append(
            f"{dive.unusable_poses} readings of odometry have no orientation, a quaternion of"
            " length 1, or no position, and are ignored; let the vehicle's navigation fill them in"
        )
    return notes


def _faults_of_pictures(count: int, counted: CountedRows, maximum_gap: float) -> list[str]:
    """Say which of a dive's pictures, `count` in all, could not be used, and where they pause."""
    notes = []
    if counted.refused:
        notes.append(
            f"{counted.refused} of {count} pictures could not be used: they are damaged, of a"
            " video stream that lacks packets, have the stamp of one before, or came out of order"
        )
    if counted.back < -succession.LATE:
        notes.append("the clock of the camera jumps back; the tracker starts anew there")
    if counted.ahead > maximum_gap:
        notes.append(
            f"there are no pictures for up to {counted.ahead:.0f} s, or the camera's clock jumps"
            " ahead; the tracker starts anew there"
        )
    return notes


def _overlap_in_time(trajectory: Trajectory, counted: CountedRows) -> bool:
    """Tell whether odometry and pictures are of one time."""
    first, last = int(trajectory.stamps[0]), int(trajectory.stamps[-1])
    return first <= counted.latest and last >= counted.earliest


def _usual_pause(trajectory: Trajectory, disk: Disk) -> float:
    """Return the median time from one of at least two poses to the next [s]."""
    pauses = disk.growing(np.float64)
    for part in disk.blocks(len(trajectory.stamps), 1):
        pauses.extend(np.diff(trajectory.stamps[part.start - 1 : part.stop]) / NANOSECONDS)
    return disk.median_in_place(pauses)


def _missing_metres(counted: CountedRows, words: list[str]) -> list[str]:
    """Describe in which share of the claims there are no metres, by reason; `words` by its number.

    Metres are not computed in every picture: the share is that of the claims in which they were.
    """
    withheld = counted.reasons[1:]
    judged = int(withheld.sum()) + counted.claims_in_metres
    return [
        f"no metres at all: {reason}"
        if count == judged
        else f"no metres in {count / judged:.0%} of the claims: {reason}"
        for count, reason in zip(withheld, words[1:], strict=True)
        if count
    ]
