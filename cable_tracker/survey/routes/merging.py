"""Routes of several dives over one cable put together, each counting by its covariance.

The longest route is the axis. Each other one is laid beside it: at each point of the axis it says
how far to the left it has the cable, and how sure it is. What reaches beyond the axis prolongs it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import compress
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray, true_runs
from cable_tracker.survey.routes.dive_route import DiveRoute
from cable_tracker.survey.routes.events import Event, EventKind
from cable_tracker.survey.routes.merged_events import merged_events
from cable_tracker.survey.routes.merged_route import MergedRoute, PlacedRoute
from cable_tracker.survey.routes.route import SPACING

REACH = 5.0
"""Routes farther apart are not of one cable [m]; `SIGMAS` standard deviations if these are more."""

SIGMAS = 4.0

LEAST_OVERLAP = 5.0
"""Dives that share a shorter stretch are not of one route [m]."""

ALONG, ROUGHLY_ALONG = 0.9, 0.5
"""Least cosine of the angle between two routes of one cable, whichever way they run, and of that
with the points of an axis that are far apart."""

NOT_ALONG = 1e6
"""What another direction counts for, beside the distance [m]."""

DISAGREEMENT = 10.8
"""Chi square of one degree of freedom that sound dives exceed once in a thousand times."""

LEAST_DISAGREEMENT = 2.0
"""Dives that disagree over a shorter stretch are no event [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class _Axis:
    """What routes are laid beside.

    Attributes
    ----------
    places : FloatArray
        x, y, shape (N, 2) [m].
    sigmas : FloatArray
        Standard deviation across it, shape (N,) [m].
    """

    places: FloatArray
    sigmas: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Beside:
    """A route as seen from an axis of N points; NaN where it does not reach.

    Where it has left the cable of the axis it does not count. `along` holds the arc
    lengths of the route's own points along the axis, in points.
    """

    recording: str
    along: FloatArray
    asides: FloatArray
    counts: BoolArray
    variances: FloatArray
    visible: FloatArray
    diameters: FloatArray
    vehicle: FloatArray


class _WeightedMean(NamedTuple):
    """Where routes have the cable together, at N points of an axis.

    Attributes
    ----------
    asides : FloatArray
        How far to the left of the axis, shape (N,) [m]; 0 where none of them can say.
    sigmas : FloatArray
        Standard deviation of that, shape (N,) [m]; interpolated where none of them can say.
    counts : IndexArray
        Number of routes that can say, shape (N,).
    excess : FloatArray
        Chi square by degree of freedom, shape (N,): more than 1 where they are farther apart than
        they say themselves.
    """

    asides: FloatArray
    sigmas: FloatArray
    counts: IndexArray
    excess: FloatArray


def merge(routes: Sequence[PlacedRoute]) -> list[MergedRoute]:
    """Merge routes of one frame; those that share no stretch stay routes of their own.

    So do stretches on which a dive has left the cable that it shares with others.
    """
    left = list(routes)
    merged = []
    while left:
        # The longest first.
        left.sort(key=lambda each: float(each.route.along[0] - each.route.along[-1]))
        axis, begin = _Axis(left[0].route.places, left[0].route.total_sigmas), 0
        group, left = [left[0]], left[1:]
        # What prolongs the axis may bring others within reach.
        while True:
            near = [each for each in left if _overlap(axis, each.route) >= LEAST_OVERLAP]
            if not near:
                break
            for each in near:
                axis, added = _prolonged(axis, each.route)
                begin += added
            group += near
            left = [each for each in left if each not in near]
        for number, each in enumerate(group[1:], start=1):
            departed = _departed(axis, each)
            group[number] = _without(each, departed)
            left += departed
        merged.append(_merged(axis, begin, group))
    return merged


def _departed(axis: _Axis, placed: PlacedRoute) -> list[PlacedRoute]:
    """Return the stretches on which a dive has left an axis, with their events."""
    route = placed.route
    away = ~_of_one_cable(axis, route, *_along_and_aside(axis.places, route.places))
    return [
        _stretch(placed, slice(first, last))
        for first, last in true_runs(away)
        if (last - first) * SPACING >= LEAST_OVERLAP
    ]


def _stretch(placed: PlacedRoute, part: slice) -> PlacedRoute:
    route = placed.route
    columns = {
        name: getattr(route, name)[part]
        for name in (each.name for each in fields(route))
        if name not in {"start", "profile"}
    }
    cut = replace(route, **columns)
    first, last = cut.along[0], cut.along[-1]
    events = tuple(each for each in placed.events if first <= each.along <= last)
    return PlacedRoute(placed.recording, cut, events)


def _without(placed: PlacedRoute, stretches: Sequence[PlacedRoute]) -> PlacedRoute:
    """Return a dive without the events of some of its stretches."""
    moved = {id(event) for each in stretches for event in each.events}
    return replace(placed, events=tuple(e for e in placed.events if id(e) not in moved))


def _directions(axis: FloatArray) -> FloatArray:
    steps = np.gradient(axis, axis=0)
    length = np.maximum(np.hypot(*steps.T), 1e-9)
    directions: FloatArray = steps / length[:, None]
    return directions


def _along_and_aside(axis: FloatArray, places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return for the points of a route (M, 2) how far along an axis [points] and to its left [m].

    Places beyond its ends have an arc length below 0 or above N - 1. Where the axis crosses itself,
    the branch counts that runs as the route does.
    """
    from_axis = np.empty((len(places), 2))
    directions, own_directions = _directions(axis), _directions(places)
    block = 512
    for begin in range(0, len(places), block):
        part = places[begin : begin + block]
        nearest = _nearest(axis, directions, part, own_directions[begin : begin + block])
        apart = part - axis[nearest]
        beyond = (apart * directions[nearest]).sum(axis=1) / SPACING
        normal = np.column_stack((-directions[nearest, 1], directions[nearest, 0]))
        from_axis[begin : begin + block, 0] = nearest + beyond
        from_axis[begin : begin + block, 1] = (apart * normal).sum(axis=1)
    return from_axis[:, 0], from_axis[:, 1]


def _nearest(
    axis: FloatArray, directions: FloatArray, places: FloatArray, own_directions: FloatArray
) -> IndexArray:
    """Return the axis' nearest point for each place: of every 16th first, then of those around.

    What runs along the place's own direction, whichever way, is nearer than all that does not.
    """
    stride = 16

    def away(points: FloatArray, courses: FloatArray, least: float) -> FloatArray:
        squares: FloatArray = ((places[:, None] - points) ** 2).sum(axis=2)
        cosines = np.abs((own_directions[:, None] * courses).sum(axis=2))
        return np.where(cosines > least, squares, squares + NOT_ALONG**2)

    coarse = away(axis[None, ::stride], directions[None, ::stride], ROUGHLY_ALONG).argmin(axis=1)
    begin = np.clip((coarse - 1) * stride, 0, max(len(axis) - 2 * stride - 1, 0))
    window = np.minimum(begin[:, None] + np.arange(2 * stride + 1), len(axis) - 1)
    fine = away(axis[window], directions[window], ALONG).argmin(axis=1)
    nearest: IndexArray = window[np.arange(len(places)), fine]
    return nearest


def _overlap(axis: _Axis, route: DiveRoute) -> float:
    """Return the length of the longest stretch that a route shares with an axis [m]."""
    along, aside = _along_and_aside(axis.places, route.places)
    shared = (
        (along >= 0) & (along <= len(axis.places) - 1) & _of_one_cable(axis, route, along, aside)
    )
    return max((last - first for first, last in true_runs(shared)), default=0) * SPACING


def _nearest_points(axis: _Axis, along: FloatArray) -> IndexArray:
    """Return the points of an axis that are nearest to arc lengths along it (M,), in points."""
    nearest: IndexArray = np.clip(np.round(along), 0, len(axis.places) - 1).astype(np.int64)
    return nearest


def _in_reach(axis: _Axis, route: DiveRoute, along: FloatArray, aside: FloatArray) -> BoolArray:
    """Tell which points of a route (N,) are not too far from an axis for one cable.

    `along` and `aside` are those of `_along_and_aside`.
    """
    sigmas = np.hypot(route.total_sigmas, axis.sigmas[_nearest_points(axis, along)])
    in_reach: BoolArray = np.abs(aside) <= np.maximum(REACH, SIGMAS * sigmas)
    return in_reach


def _of_one_cable(axis: _Axis, route: DiveRoute, along: FloatArray, aside: FloatArray) -> BoolArray:
    """Tell which points of a route (N,) are near an axis, and run along it; see `_in_reach`."""
    directions = _directions(axis.places)[_nearest_points(axis, along)]
    cosines = (_directions(route.places) * directions).sum(axis=1)
    fits: BoolArray = _in_reach(axis, route, along, aside) & (np.abs(cosines) > ALONG)
    return fits


def _prolonged(axis: _Axis, route: DiveRoute) -> tuple[_Axis, int]:
    """Return an axis with what a route has beyond its ends, unless it left the cable before.

    And how many points that is before its beginning.
    """
    along, aside = _along_and_aside(axis.places, route.places)
    places, sigmas, in_reach = (
        route.places, route.total_sigmas, _in_reach(axis, route, along, aside)
    )  # fmt: skip
    if along[-1] < along[0]:
        along, places, sigmas, in_reach = along[::-1], places[::-1], sigmas[::-1], in_reach[::-1]
    before = np.flatnonzero(along < -0.5)
    after = np.flatnonzero(along > len(axis.places) - 0.5)
    parts, doubts, added = [axis.places], [axis.sigmas], 0
    if len(before) and in_reach[before[-1]]:
        shift = axis.places[0] - _directions(axis.places)[0] * SPACING - places[before[-1]]
        parts.insert(0, places[before] + shift)
        doubts.insert(0, sigmas[before])
        added = len(before)
    if len(after) and in_reach[after[0]]:
        shift = axis.places[-1] + _directions(axis.places)[-1] * SPACING - places[after[0]]
        parts.append(places[after] + shift)
        doubts.append(sigmas[after])
    return _Axis(np.concatenate(parts), np.concatenate(doubts)), added


def _beside(axis: _Axis, placed: PlacedRoute, begin: int | None) -> _Beside:
    """Lay a route beside an axis.

    `begin` is the index of its first point on an axis that was made of it, which counts all along;
    None for other routes.
    """
    route, is_axis = placed.route, begin is not None
    if begin is None:
        all_along, aside = _along_and_aside(axis.places, route.places)
    else:
        # Not looked for: a cable that crosses itself comes near to itself.
        count = len(route.along)
        all_along, aside = begin + np.arange(count, dtype=np.float64), np.zeros(count)
    order = np.argsort(all_along, kind="stable")
    along, asked = all_along[order], np.arange(len(axis.places), dtype=np.float64)
    reaches = (asked >= along[0] - 0.5) & (asked <= along[-1] + 0.5)
    visible, unjudged = (x.astype(float) for x in (route.visible(), route.unjudged()))

    def on_axis(values: FloatArray) -> FloatArray:
        found = np.interp(asked, along, values[order])
        return np.where(reaches, found, np.nan)

    of_one_cable = is_axis | _of_one_cable(axis, route, all_along, aside)[order]
    counts = reaches & (np.interp(asked, along, of_one_cable) == 1.0)

    def of_the_cable(values: FloatArray) -> FloatArray:
        return np.where(counts, on_axis(values), np.nan)

    return _Beside(
        placed.recording,
        all_along,
        on_axis(aside),
        counts,
        on_axis(route.total_sigmas**2),
        np.where(counts & ~(on_axis(unjudged) > 0.5), on_axis(visible) > 0.5, np.nan),
        of_the_cable(route.diameters),
        of_the_cable(np.abs(route.asides)),
    )


def _merged(of_group: _Axis, begin: int, group: Sequence[PlacedRoute]) -> MergedRoute:
    """Merge a group; from its point number `begin` on, the axis is the first one's route."""
    axis = of_group.places
    beside = [_beside(of_group, each, begin if each is group[0] else None) for each in group]
    counts = np.array([each.counts for each in beside])
    asides = np.where(counts, [each.asides for each in beside], np.nan)
    mean = _weighted_mean(asides, np.array([each.variances for each in beside]))
    directions = _directions(axis)
    normal = np.column_stack((-directions[:, 1], directions[:, 0]))
    places = axis + mean.asides[:, None] * normal
    recordings = [each.recording for each in beside]
    coverage = _coverage(recordings, asides)
    merged = MergedRoute(
        along=np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T)))),
        places=places,
        headings=np.unwrap(np.arctan2(*_directions(places).T[::-1])),
        sigmas=mean.sigmas,
        visible=_mean([each.visible for each in beside]),
        diameters=_mean([each.diameters for each in beside]),
        asides=_mean([each.vehicle for each in beside]),
        dives=np.sum(list(coverage.values()), axis=0, dtype=np.float64),
        events=(),
        recordings=tuple(coverage),
    )
    apart = (mean.counts > 1) & (mean.excess > DISAGREEMENT)
    disagreements = _disagreements(merged, apart, asides, recordings)
    events = [*merged_events(merged, group, [each.along for each in beside]), *disagreements]
    events.sort(key=lambda event: (event.along, event.kind.value))
    return replace(merged, events=tuple(events))


def _weighted_mean(asides: FloatArray, variances: FloatArray) -> _WeightedMean:
    """Average how far routes (R) are aside of an axis (N), each counting by its variance.

    `asides` (R, N) [m] are NaN where a route does not count; `variances` (R, N) [m2].
    """
    weights = 1.0 / variances
    weights[~np.isfinite(asides)] = np.nan
    total = np.nansum(weights, axis=0)
    known = total > 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(known, np.nansum(weights * asides, axis=0) / total, 0.0)
        sigma = np.sqrt(1.0 / total)
        chi = np.nansum(weights * (asides - mean) ** 2, axis=0)
    count = np.isfinite(asides).sum(axis=0)
    excess = chi / np.maximum(count - 1, 1)
    # Dives that disagree are less sure together than each of them says.
    sigma = np.where(known, sigma * np.sqrt(np.maximum(excess, 1.0)), np.nan)
    sigma = np.interp(np.arange(len(known)), np.flatnonzero(known), sigma[known])
    return _WeightedMean(mean, sigma, count, excess)


def _coverage(recordings: Sequence[str], asides: FloatArray) -> dict[str, BoolArray]:
    """Return for each dive at which points of an axis (N,) one of its routes counts.

    A dive may have gone along the same cable twice.
    """
    coverage: dict[str, BoolArray] = {}
    for recording, aside in zip(recordings, asides, strict=True):
        seen = coverage.get(recording, np.zeros(len(aside), np.bool_))
        coverage[recording] = seen | np.isfinite(aside)
    return coverage


def _mean(columns: Sequence[FloatArray]) -> FloatArray:
    values = np.array(columns)
    count = np.isfinite(values).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean: FloatArray = np.where(count > 0, np.nansum(values, axis=0) / count, np.nan)
    return mean


def _disagreements(
    route: MergedRoute, apart: BoolArray, asides: FloatArray, recordings: Sequence[str]
) -> list[Event]:
    """Return where dives (N) disagree, from how far each is aside of the axis, (N, M) [m]."""
    events = []
    for first, last in true_runs(apart):
        start, end = float(route.along[first]), float(route.along[last - 1])
        if end - start < LEAST_DISAGREEMENT:
            continue
        part = asides[:, first:last]
        most = float(np.nanmax(np.nanmax(part, axis=0) - np.nanmin(part, axis=0)))
        place = (float(route.places[first, 0]), float(route.places[first, 1]))
        detail = f"up to {most:.2f} m apart, more than their covariances allow"
        seen = np.count_nonzero(np.isfinite(part), axis=1)
        first_name, *others = dict.fromkeys(compress(recordings, seen))
        kind = EventKind.DISAGREEMENT
        events.append(Event(kind, start, end, place, 0, -1, detail, first_name, tuple(others)))
    return events
