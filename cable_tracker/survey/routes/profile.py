"""Visibility of the cable along a route, from the profiles of the pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.survey.curve_filter import SmoothedCable
from cable_tracker.survey.frame_table import (
    HIDDEN,
    Rows,
    is_claimed,
    is_measured,
    is_withheld,
)
from cable_tracker.survey.georeference import Georeference
from cable_tracker.survey.keyframes import Keyframes, filled
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.routes.dive_route import PROFILE_SPACING, Profile

ON_ROUTE = 4.0
"""Claims farther from the smoothed cable than this say nothing about it [standard deviations]."""

LEAST_WEIGHT = 0.05
"""Claims that count less in the smoothing are of something else."""

TOGETHER = 4096
"""Number of rows of the table that are added up before they are added to the others."""


@dataclass(frozen=True, slots=True, eq=False)
class SmoothedDive:
    """A smoothed dive that routes are made of.

    Attributes
    ----------
    keyframes : Keyframes
        Keyframes of the dive.
    cable : SmoothedCable
        Smoothed states of the cable at the keyframes.
    rows : Rows
        Rows of the `FrameTable`, shape (N,).
    look : FloatArray
        x of the look line in each row, ahead of the vehicle, shape (N,) [m].
    earth : Georeference or None
        Takes the dive's frame to that of the routes; None: they stay in it.
    disk : Disk
        Allocator of intermediate arrays.
    """

    keyframes: Keyframes
    cable: SmoothedCable
    rows: Rows
    look: FloatArray
    earth: Georeference | None
    disk: Disk

    def row_blocks(self, piece: slice) -> Iterator[tuple[slice, IndexArray]]:
        """Yield the rows of connected keyframes in blocks, and the keyframe of each row; -1: none.

        Rows before the piece's first keyframe, or after its last, belong to none.
        """
        first, last = self.keyframes.first[piece.start], self.keyframes.last[piece.stop - 1]
        for part in self.disk.blocks(int(last), int(first)):
            yield part, self.keyframes.of_rows(part)


def make_profile(dive: SmoothedDive, piece: slice, wanted: FloatArray) -> Profile:
    """Gather what each picture showed of each place along the cable.

    Parameters
    ----------
    dive : SmoothedDive
        The dive.
    piece : slice
        Its connected keyframes that the route is made of.
    wanted : FloatArray
        Arc lengths along the cable of the route's points, shape (N,) [m].
    """
    cable, rows, disk, first = dive.cable, dive.rows, dive.disk, float(wanted[0])
    count = max(1, int(np.ceil((float(wanted[-1]) - first) / PROFILE_SPACING)))
    judged = disk.growing(np.int64)
    for part, owner in dive.row_blocks(piece):
        judged.extend(part.start + _judged_rows(cable, rows[part], owner))
    used = judged.rows()
    total, number = disk.array(count), disk.array(count, np.int64)
    for start in range(0, len(used), TOGETHER):
        some = used[start : start + TOGETHER]
        own = dive.keyframes.of(some)
        ahead = rows["profile_ahead"][some].astype(np.float64) - rows["look"][some][:, None]
        along = cable.along[own][:, None] + ahead / np.cos(cable.states[own, 1])[:, None]
        scores = rows["profile_score"][some]
        place = np.floor((along - first) / PROFILE_SPACING)
        fine = np.isfinite(place) & np.isfinite(scores) & (place >= 0) & (place < count)
        index = place[fine].astype(np.int64)
        if len(index):
            low = int(index.min())
            counts = np.bincount(index - low)
            total[low : low + len(counts)] += np.bincount(index - low, scores[fine])
            number[low : low + len(counts)] += counts
        disk.release_pages()
    with np.errstate(invalid="ignore", divide="ignore"):
        seen = np.where(number > 0, total / number, np.nan)
    in_view = _mostly(disk, first, count, _in_view(dive, piece))
    return Profile(0.0, seen, in_view, _mostly(disk, first, count, _withheld(dive, piece)))


def _judged_rows(cable: SmoothedCable, rows: Rows, owner: IndexArray) -> IndexArray:
    """Return the rows (of keyframes `owner`, (K,)) whose profile judges this cable."""
    used = np.flatnonzero((owner >= 0) & (is_claimed(rows) | (rows["again"] == HIDDEN)))
    keyframe = owner[used]
    off = np.abs(rows["aside"][used] - cable.states[keyframe, 0])
    allowed = ON_ROUTE * np.sqrt(cable.covariances[keyframe, 0, 0]) + 0.05
    # What is claimed of something else says nothing about the cable.
    counts = (off <= allowed) & (cable.weights[keyframe] > LEAST_WEIGHT)
    counts |= rows["again"][used] == HIDDEN
    judged: IndexArray = used[counts]
    return judged


def _in_view(dive: SmoothedDive, piece: slice) -> Iterator[tuple[FloatArray, BoolArray]]:
    """Yield arc lengths, and whether the cable passed through a picture with the camera there."""
    half_views = filled(dive.rows["half_view"], dive.disk)
    for part in dive.disk.blocks(piece.stop, piece.start):
        seen = half_views[dive.keyframes.first[part]]
        yield dive.cable.along[part], np.abs(dive.cable.states[part, 0]) < seen


def _withheld(dive: SmoothedDive, piece: slice) -> Iterator[tuple[FloatArray, BoolArray]]:
    """Yield arc lengths, and whether claims with the camera there were without metres."""
    for part, owner in dive.row_blocks(piece):
        withheld = is_withheld(dive.rows[part])
        used = (owner >= 0) & (is_measured(dive.rows[part]) | withheld)
        yield dive.cable.along[owner[used]], withheld[used]


def _mostly(
    disk: Disk, first: float, count: int, blocks: Iterable[tuple[FloatArray, BoolArray]]
) -> BoolArray:
    """Tell for each of the places from `first` [m] on whether something is so mostly, (count,).

    Each block says for some arc lengths along the cable (K,) [m] whether it is so there, (K,).
    Between places of which none says anything, it is interpolated.
    """
    so, passed = disk.array(count), disk.array(count)
    for along, is_so in blocks:
        place = np.floor((along - first) / PROFILE_SPACING).astype(np.int64)
        fine = (place >= 0) & (place < count)
        np.add.at(so, place[fine], is_so[fine].astype(float))
        np.add.at(passed, place[fine], 1.0)
    known = np.flatnonzero(passed)
    if not len(known):
        return np.zeros(count, bool)
    shares = so[known] / passed[known]
    return np.asarray(np.interp(np.arange(count), known, shares) >= 0.5)
