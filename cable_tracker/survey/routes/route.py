"""Routes made of the smoothed keyframes of a dive: points at even distances along the cable."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.survey.curve_filter import SmoothedCable
from cable_tracker.survey.frame_table import Rows, is_claimed
from cable_tracker.survey.georeference import Georeference
from cable_tracker.survey.keyframes import Keyframes, filled
from cable_tracker.survey.memory_mapped import Disk, Unwrapping, interpolated_locally
from cable_tracker.survey.routes.dive_route import DiveRoute
from cable_tracker.survey.routes.profile import LEAST_WEIGHT, SmoothedDive, make_profile
from cable_tracker.survey.trajectory import Trajectory

SPACING = 0.5
"""Distance between two points of a route [m]."""

BEYOND = 1.0
"""Length of a route beyond its first and its last claim [m]."""

FEWEST_KEYFRAMES = 4

BIN = SPACING / 4
"""Keyframes are averaged over this length [m]."""

PLACED = np.dtype([("place", "i8"), ("value", "f8")])
"""Number of a point of a route, and what was measured there."""

COLUMNS = 8
"""Number of columns of a route at each of its keyframes."""


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A dive, smoothed.

    Attributes
    ----------
    trajectory : Trajectory
        Trajectory of the vehicle.
    keyframes : Keyframes
        Keyframes of the dive.
    cable : SmoothedCable
        Smoothed states of the cable at the keyframes.
    """

    trajectory: Trajectory
    keyframes: Keyframes
    cable: SmoothedCable


def make_routes(
    keyframes: Keyframes,
    cable: SmoothedCable,
    rows: Rows,
    disk: Disk,
    earth: Georeference | None = None,
) -> list[DiveRoute]:
    """Return one route for each connected piece of a dive that was claimed at all.

    Parameters
    ----------
    keyframes, cable
        Keyframes, and their smoothed states, of `smoothing`.
    rows : Rows
        Rows of the `FrameTable`, shape (N,).
    disk : Disk
        Allocator of intermediate arrays.
    earth : Georeference or None
        Takes the dive's frame to that of the routes; None: they stay in it.
    """
    dive = SmoothedDive(keyframes, cable, rows, filled(rows["look"], disk), earth, disk)
    starts = np.flatnonzero(np.diff(cable.piece, prepend=-1))
    routes = []
    for start, end in pairwise([*starts.tolist(), len(cable.piece)]):
        claimed = _claimed_part(dive, start, end)
        if claimed.count >= FEWEST_KEYFRAMES and claimed.most - claimed.least > SPACING:
            own = _with_margin(dive, slice(start, end), claimed)
            routes.append(_Piece(dive, own, (claimed.least, claimed.most)).route())
    return routes


@dataclass(slots=True)
class _Claimed:
    """Keyframes with claims of a connected piece: number, first, last, and span [m]."""

    count: int = 0
    first: int = 0
    last: int = 0
    least: float = math.inf
    most: float = -math.inf


def _claimed_part(dive: SmoothedDive, start: int, end: int) -> _Claimed:
    """Return where among the keyframes from `start` up to `end` the claims are."""
    found = _Claimed()
    for part in dive.disk.blocks(end, start):
        claimed = np.flatnonzero(dive.cable.weights[part] > 0.0) + part.start
        if len(claimed):
            along = dive.cable.along[claimed]
            found.first = found.first if found.count else int(claimed[0])
            found.last, found.count = int(claimed[-1]), found.count + len(claimed)
            found.least = min(found.least, float(along.min()))
            found.most = max(found.most, float(along.max()))
    return found


def _with_margin(dive: SmoothedDive, piece: slice, claimed: _Claimed) -> slice:
    """Return the keyframes of a piece from the first to the last claim, and `BEYOND` these.

    Others are of no cable, however far along it they seem to be: the vehicle comes to it, or has
    left it.
    """
    start, end = piece.start, piece.stop

    def away(part: slice, claim: int) -> IndexArray:
        apart = _cable_points(dive, part) - _cable_points(dive, slice(claim, claim + 1))
        far: IndexArray = np.flatnonzero(np.hypot(*apart.T) > BEYOND) + part.start
        return far

    for part in dive.disk.blocks_reversed(claimed.first, start):
        if len(far := away(part, claimed.first)):
            start = int(far[-1]) + 1
            break
    for part in dive.disk.blocks(end, claimed.last):
        if len(far := away(part, claimed.last)):
            end = int(far[0])
            break
    return slice(start, end)


def _cable_points(dive: SmoothedDive, part: slice) -> FloatArray:
    """Return where the cable crosses the look lines of some keyframes, shape (K, 2) [m]."""
    aside, yaw = dive.cable.states[part, 0], dive.keyframes.look_lines[part, 2]
    points: FloatArray = dive.keyframes.look_lines[part, :2].copy()
    points[:, 0] -= aside * np.sin(yaw)
    points[:, 1] += aside * np.cos(yaw)
    return points


class _Piece:
    """Keyframes `own`, which are connected; see `make_routes`.

    `claimed` is the least and the most arc length of those with claims [m].
    """

    def __init__(self, dive: SmoothedDive, own: slice, claimed: tuple[float, float]) -> None:
        self._dive, self._disk = dive, dive.disk
        self._own = own
        self._along = dive.cable.along[own]
        self._least = min(float(self._along[part].min()) for part in self._blocks())
        most = max(float(self._along[part].max()) for part in self._blocks())
        first, last = max(claimed[0] - BEYOND, self._least), min(claimed[1] + BEYOND, most)
        self._bins = math.floor((most - self._least) / BIN) + 1
        count = max(round((last - first) / SPACING), 1) + 1
        self._wanted: FloatArray = np.arange(count, dtype=np.float64) * SPACING + first

    def _blocks(self) -> Iterator[slice]:
        return self._disk.blocks(len(self._along))

    def route(self) -> DiveRoute:
        """Return the route along these keyframes."""
        wanted, keyframes, disk = self._wanted, self._dive.keyframes, self._disk
        found, following = self._at_wanted()
        route = DiveRoute(
            start=float(wanted[0]),
            along=wanted - wanted[0],
            places=found[:, :2],
            headings=found[:, 2],
            sigmas=found[:, 3],
            frame_variances=found[:, 4],
            bends=found[:, 5],
            bend_sigmas=found[:, 6],
            stamps=keyframes.stamps[following],
            rows=keyframes.first[following],
            diameters=self._diameters(),
            asides=found[:, 7],
            profile=make_profile(self._dive, self._own, wanted),
        )
        disk.release_pages()
        return route

    def _at_wanted(self) -> tuple[FloatArray, IndexArray]:
        """Return the `_columns` at the wanted arc lengths (N, C), and keyframes (N,).

        They are the first keyframes at or beyond the wanted arc lengths.

        Keyframes are averaged in bins of a quarter of the spacing: a stretch seen twice is one.
        """
        disk, along, wanted = self._disk, self._along, self._wanted
        order = disk.array(len(along), np.int64)
        order[:] = np.argsort(along, kind="stable")
        sorted_along = disk.filled(len(along), lambda part: along[order[part]])
        following = order[np.clip(np.searchsorted(sorted_along, wanted), 0, len(order) - 1)]
        headings = self._headings(order)
        counts = disk.array(self._bins, np.int64)
        totals = [disk.array(self._bins) for _ in range(COLUMNS + 1)]
        for part in self._blocks():
            bins = np.floor((along[part] - self._least) / BIN).astype(np.int64)
            np.add.at(counts, bins, 1)
            columns = (along[part], *self._columns(part, headings))
            for total, column in zip(totals, columns, strict=True):
                # In the order of the keyframes, one after the other.
                np.add.at(total, bins, column)
        used = disk.growing(np.int64)
        for part in disk.blocks(self._bins):
            used.extend(np.flatnonzero(counts[part]) + part.start)
        bins = used.rows()

        def means(total: FloatArray) -> FloatArray:
            mean: FloatArray = disk.filled(
                len(bins), lambda part: total[bins[part]] / counts[bins[part]]
            )
            return mean

        along = means(totals[0])
        found = [_at_even_spacing(wanted, along, means(total), disk) for total in totals[1:]]
        return np.column_stack(found), following + self._own.start

    def _headings(self, order: IndexArray) -> FloatArray:
        """Return the cable's directions (M,); `order` (M,) is that of the keyframes along it.

        They go on from one place of the cable to the next, not from one keyframe to the next.
        """
        keyframes, cable = self._dive.keyframes, self._dive.cable
        headings: FloatArray = self._disk.array(len(order))
        unwrapping = Unwrapping()
        turn = 0.0 if self._dive.earth is None else self._dive.earth.turn
        for part in self._disk.blocks(len(order)):
            own = order[part] + self._own.start
            raw = keyframes.look_lines[own, 2] + cable.states[own, 1]
            headings[order[part]] = unwrapping.apply(raw) + turn
        return headings

    def _columns(self, part: slice, headings: FloatArray) -> Iterator[FloatArray]:
        """Yield what a route says of some of its keyframes, `COLUMNS` columns (K,).

        x, y, direction, standard deviation across, what the frame adds to its square, curvature,
        its standard deviation, distance from the vehicle.
        """
        keyframes, cable, earth = self._dive.keyframes, self._dive.cable, self._dive.earth
        own = slice(part.start + self._own.start, part.stop + self._own.start)
        points = _cable_points(self._dive, own)
        frame_variances = np.zeros(len(points))
        if earth is not None:
            points, frame_variances = earth.apply(points, keyframes.stamps[own])
        yield from points.T
        yield headings[part]
        slope = np.abs(np.cos(cable.states[own, 1]))
        yield np.sqrt(cable.covariances[own, 0, 0]) * slope
        yield frame_variances
        yield cable.states[own, 2]
        yield np.sqrt(cable.covariances[own, 2, 2])
        yield self._asides(own)

    def _asides(self, own: slice) -> FloatArray:
        """Return how far to the left of the vehicle's middle the cable runs, (K,) [m].

        Where the camera looks, ahead of it, a vehicle that crabs has the cable elsewhere.
        """
        (aside, heading, _), dive = self._dive.cable.states[own].T, self._dive
        look = dive.look[dive.keyframes.first[own]]
        asides: FloatArray = aside * np.cos(heading) - look * np.sin(heading)
        return asides

    def _diameters(self) -> FloatArray:
        """Return the median diameter around each wanted place, shape (N,) [m]."""
        cable, wanted = self._dive.cable, self._wanted
        seen = self._disk.growing(PLACED)
        for part, owner in self._dive.row_blocks(self._own):
            rows = self._dive.rows[part]
            known = (owner >= 0) & is_claimed(rows) & np.isfinite(rows["diameter"])
            known &= cable.weights[owner] > LEAST_WEIGHT
            place = np.round((cable.along[owner[known]] - wanted[0]) / SPACING).astype(np.int64)
            inside = (place >= 0) & (place < len(wanted))
            some = np.zeros(int(inside.sum()), PLACED)
            some["place"], some["value"] = place[inside], rows["diameter"][known][inside]
            seen.extend(some)
        values = seen.rows()
        order = np.argsort(values["place"], kind="stable")
        edges = np.cumsum(self._counts_of(values))
        found = np.full(len(wanted), np.nan)
        for place, (start, end) in enumerate(pairwise([0, *edges.tolist()])):
            if end > start:
                found[place] = np.median(values["value"][order[start:end]])
        return found

    def _counts_of(self, values: Rows) -> IndexArray:
        """Return how many values there are of each wanted place, shape (N,)."""
        counts = np.zeros(len(self._wanted), np.int64)
        for part in self._disk.blocks(len(values)):
            np.add.at(counts, values["place"][part], 1)
        return counts


def _at_even_spacing(
    wanted: FloatArray, along: FloatArray, values: FloatArray, disk: Disk
) -> FloatArray:
    """Return values (M,) at arc lengths (M,) that grow, interpolated at wanted ones (N,)."""
    if len(along) < 2:
        return np.full(len(wanted), values[0])
    found = np.zeros(len(wanted))
    for part in disk.blocks(len(wanted)):
        found[part] = interpolated_locally(wanted[part], along, values)
    return found
