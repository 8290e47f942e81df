"""From the smoothed looks of a dive to a route: points at even distances along the cable."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.survey.frame_table import HIDDEN, Rows, is_claimed
from cable_tracker.survey.navigation import Poses
from cable_tracker.survey.smoothing import Looks, SmoothedCable, filled

SPACING = 0.5
"""Between two points of a route [m]."""

PROFILE_SPACING = 0.1
"""Between two places at which it is judged whether the cable can be seen [m]."""

VISIBLE = 1.6
"""A mean score of the borders above this is a cable that can be seen; see `visibility`."""

SMOOTHED_BINS = 3
"""Places over which the mean score is averaged."""

BEYOND = 1.0
"""A route goes on so far beyond the first and the last claim [m]."""

ON_ROUTE = 4.0
"""Claims farther from the smoothed cable than this say nothing about it [standard deviations]."""

LEAST_WEIGHT = 0.05
"""Claims that count less in the smoothing are of something else."""

FEWEST_LOOKS = 4

BLOCK = 4096
"""So many rows of the table are looked at together."""


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """What can be seen of a cable along its way.

    Attributes
    ----------
    start : float
        Where it begins along the way [m]; the places are `PROFILE_SPACING` apart.
    seen : FloatArray
        How clearly the borders are seen, shape (B,); NaN where they were not measured.
    in_view : BoolArray
        Whether the cable, seen or not, was inside some picture, shape (B,).
    """

    start: float
    seen: FloatArray
    in_view: BoolArray

    @property
    def along(self) -> FloatArray:
        """Middle of each place along the way, shape (B,) [m]."""
        return np.array(self.start + PROFILE_SPACING * (np.arange(len(self.seen)) + 0.5))

    @property
    def visible(self) -> BoolArray:
        """Whether the cable can be seen, shape (B,)."""
        kernel = np.ones(SMOOTHED_BINS)
        known = np.isfinite(self.seen)
        total = np.convolve(np.where(known, self.seen, 0.0), kernel, "same")
        count = np.convolve(known.astype(float), kernel, "same")
        with np.errstate(invalid="ignore", divide="ignore"):
            above: BoolArray = known & (total / count > VISIBLE)
        return above


@dataclass(frozen=True, slots=True, eq=False)
class DiveRoute:
    """A piece of cable as one dive has it.

    Columns have one value for each point; see `SPACING`.

    Attributes
    ----------
    start : float
        Where it begins along the way of `SmoothedCable` [m].
    along : FloatArray
        Way along the cable from there [m].
    places : FloatArray
        x, y, shape (N, 2) [m].
    headings : FloatArray
        Direction of the cable from +x [rad].
    sigmas : FloatArray
        Standard deviation across the cable [m], in the dive's frame.
    frame_variances : FloatArray
        What the frame adds to it [m²]; 0 in the frame of odometry.
    bends : FloatArray
        Curvature, to the left [1/m].
    bend_sigmas : FloatArray
        Its standard deviation [1/m].
    stamps : IndexArray
        When the vehicle was there [ns].
    rows : IndexArray
        Which row of the table is of that time.
    diameters : FloatArray
        [m]; NaN where there was no claim.
    asides : FloatArray
        Lateral distance of the cable from the vehicle's middle, to the left [m].
    profile : Profile
        What can be seen along the way.
    """

    start: float
    along: FloatArray
    places: FloatArray
    headings: FloatArray
    sigmas: FloatArray
    frame_variances: FloatArray
    bends: FloatArray
    bend_sigmas: FloatArray
    stamps: IndexArray
    rows: IndexArray
    diameters: FloatArray
    asides: FloatArray
    profile: Profile = field(repr=False)

    @property
    def total_sigmas(self) -> FloatArray:
        """Standard deviation across the cable, with what is unknown of the frame [m]."""
        return np.array(np.sqrt(self.sigmas**2 + self.frame_variances))

    def visible(self) -> BoolArray:
        """Tell at each point whether the cable can be seen, shape (N,)."""
        shares = np.interp(self.along, self.profile.along, self.profile.visible.astype(float))
        return np.asarray(shares > 0.5)


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """A dive, smoothed.

    Attributes
    ----------
    poses : Poses
        Of the vehicle.
    looks : Looks
        Where its camera looked.
    cable : SmoothedCable
        Where the cable is there.
    """

    poses: Poses
    looks: Looks
    cable: SmoothedCable


Placing = Callable[[FloatArray, IndexArray], tuple[FloatArray, FloatArray]]
"""Takes places (N, 2) and stamps (N,) to places of another frame and variances (N,) [m²]."""


def make_routes(
    looks: Looks,
    cable: SmoothedCable,
    rows: Rows,
    placing: Placing | None = None,
    turn: float = 0.0,
) -> list[DiveRoute]:
    """Return one route for each connected piece of a dive that was claimed at all.

    Parameters
    ----------
    looks, cable
        Of `smoothing`.
    rows : Rows
        Of the `FrameTable`.
    placing : callable or None
        Takes places of the dive's frame to the frame of the route; None leaves them.
    turn : float
        By how much directions turn with it [rad].
    """
    routes = []
    for number in range(int(cable.piece.max()) + 1 if len(cable.piece) else 0):
        members = np.flatnonzero(cable.piece == number)
        claimed = members[cable.weights[members] > 0.0]
        if len(claimed) >= FEWEST_LOOKS and np.ptp(cable.along[claimed]) > SPACING:
            routes.append(_route(looks, cable, rows, (members, claimed), (placing, turn)))
    return routes


def _route(
    looks: Looks,
    cable: SmoothedCable,
    rows: Rows,
    chosen: tuple[IndexArray, IndexArray],
    frame: tuple[Placing | None, float],
) -> DiveRoute:
    members, claimed = chosen
    along = cable.along[members]
    first, last = cable.along[claimed].min() - BEYOND, cable.along[claimed].max() + BEYOND
    first, last = max(first, along.min()), min(last, along.max())
    wanted = np.arange(0, max(round((last - first) / SPACING), 1) + 1) * SPACING + first
    order = np.argsort(along, kind="stable")
    found = _at_places(along, _columns(looks, cable, (members, order), frame), wanted)
    nearest = order[np.clip(np.searchsorted(along[order], wanted), 0, len(order) - 1)]
    rows_at = looks.first[members][nearest]
    relative = wanted - wanted[0]
    return DiveRoute(
        start=float(wanted[0]),
        along=relative,
        places=found[:, :2],
        headings=found[:, 2],
        sigmas=found[:, 3],
        frame_variances=found[:, 4],
        bends=found[:, 5],
        bend_sigmas=found[:, 6],
        stamps=looks.stamps[members][nearest],
        rows=rows_at,
        diameters=_diameters(looks, cable, rows, members, wanted),
        asides=found[:, 7],
        profile=_profile(looks, cable, rows, members, (float(wanted[0]), float(wanted[-1]))),
    )


def _columns(
    looks: Looks,
    cable: SmoothedCable,
    chosen: tuple[IndexArray, IndexArray],
    frame: tuple[Placing | None, float],
) -> Iterator[FloatArray]:
    """Yield what a route says of each of its looks, one column (M,) after the other.

    All of them at once would be most of what a survey takes. x, y, direction, standard deviation
    across, what the frame adds to its square, curvature, its standard deviation, lateral distance.
    """
    members, order = chosen
    placing, turn = frame
    aside, yaw = cable.states[members, 0], looks.places[members, 2]
    points = looks.places[members, :2]
    points[:, 0] -= aside * np.sin(yaw)
    points[:, 1] += aside * np.cos(yaw)
    frame_variances = np.zeros(len(points))
    if placing is not None:
        points, frame_variances = placing(points, looks.stamps[members])
    yield from points.T
    headings = yaw + cable.states[members, 1]
    # Directions go on from one place of the cable to the next, not from one look to the next.
    headings[order] = np.unwrap(headings[order]) + turn
    yield headings
    slope = np.abs(np.cos(cable.states[members, 1]))
    yield np.sqrt(cable.covariances[members, 0, 0]) * slope
    yield frame_variances
    yield cable.states[members, 2]
    yield np.sqrt(cable.covariances[members, 2, 2])
    yield aside


def _at_places(along: FloatArray, columns: Iterable[FloatArray], wanted: FloatArray) -> FloatArray:
    """Return columns (M,) at wanted places (N,), shape (N, C).

    Looks are averaged in bins of a quarter of the spacing: a way gone twice counts once.
    """
    bins = np.floor((along - along.min()) / (SPACING / 4)).astype(np.int64)
    _, places, counts = np.unique(bins, return_inverse=True, return_counts=True)
    del bins
    at = np.bincount(places, along) / counts
    return np.column_stack(
        [np.interp(wanted, at, np.bincount(places, column) / counts) for column in columns]
    )


def _rows_of(looks: Looks, members: IndexArray, count: int) -> IndexArray:
    """Return for each row of the table the look that it belongs to; -1: none of these."""
    owner = np.full(count, -1, np.int64)
    for k in members:
        owner[looks.first[k] : looks.last[k]] = k
    return owner


def _diameters(
    looks: Looks, cable: SmoothedCable, rows: Rows, members: IndexArray, wanted: FloatArray
) -> FloatArray:
    owner = _rows_of(looks, members, len(rows))
    known = (owner >= 0) & is_claimed(rows) & np.isfinite(rows["diameter"])
    known &= cable.weights[owner] > LEAST_WEIGHT
    along = cable.along[owner[known]]
    place = np.round((along - wanted[0]) / SPACING).astype(np.int64)
    inside = (place >= 0) & (place < len(wanted))
    values, place = rows["diameter"][known][inside].astype(np.float64), place[inside]
    found = np.full(len(wanted), np.nan)
    order = np.argsort(place, kind="stable")
    values, place = values[order], place[order]
    edges = np.flatnonzero(np.diff(place, prepend=-1, append=-1))
    for start, end in pairwise(edges):
        found[place[start]] = np.median(values[start:end])
    return found


def _profile(
    looks: Looks,
    cable: SmoothedCable,
    rows: Rows,
    members: IndexArray,
    limits: tuple[float, float],
) -> Profile:
    """Gather what each picture showed of each place along the way."""
    first, last = limits
    count = max(1, int(np.ceil((last - first) / PROFILE_SPACING)))
    owner = _rows_of(looks, members, len(rows))
    used = np.flatnonzero((owner >= 0) & (is_claimed(rows) | (rows["again"] == HIDDEN)))
    look = owner[used]
    off = np.abs(rows["aside"][used] - cable.states[look, 0])
    allowed = ON_ROUTE * np.sqrt(cable.covariances[look, 0, 0]) + 0.05
    # What is claimed of something else tells nothing about the cable.
    tells = (off <= allowed) & (cable.weights[look] > LEAST_WEIGHT)
    tells |= rows["again"][used] == HIDDEN
    used, look = used[tells], look[tells]
    total, number = np.zeros(count), np.zeros(count, np.int64)
    for start in range(0, len(used), BLOCK):
        some, own = used[start : start + BLOCK], look[start : start + BLOCK]
        ahead = rows["profile_ahead"][some].astype(np.float64) - rows["look"][some][:, None]
        along = cable.along[own][:, None] + ahead / np.cos(cable.states[own, 1])[:, None]
        scores = rows["profile_score"][some]
        place = np.floor((along - first) / PROFILE_SPACING)
        fine = np.isfinite(place) & np.isfinite(scores) & (place >= 0) & (place < count)
        index = place[fine].astype(np.int64)
        total += np.bincount(index, scores[fine], minlength=count)
        number += np.bincount(index, minlength=count)
    with np.errstate(invalid="ignore", divide="ignore"):
        seen = np.where(number > 0, total / number, np.nan)
    return Profile(0.0, seen, _in_view(looks, cable, rows, members, (first, count)))


def _in_view(
    looks: Looks,
    cable: SmoothedCable,
    rows: Rows,
    members: IndexArray,
    bins: tuple[float, int],
) -> BoolArray:
    """Tell for each place whether the cable passed through a picture while the camera was there."""
    first, count = bins
    half = filled(rows["half_view"])[looks.first[members]]
    inside = np.abs(cable.states[members, 0]) < half
    place = np.floor((cable.along[members] - first) / PROFILE_SPACING).astype(np.int64)
    fine = (place >= 0) & (place < count)
    seen = np.bincount(place[fine], inside[fine].astype(float), minlength=count)
    passed = np.bincount(place[fine], minlength=count)
    share = np.where(passed > 0, seen / np.maximum(passed, 1), np.nan)
    known = np.flatnonzero(np.isfinite(share))
    if not len(known):
        return np.zeros(count, bool)
    return np.asarray(np.interp(np.arange(count), known, share[known]) >= 0.5)
