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

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray, interpolated, true_runs
from cable_tracker.survey.routes.axis import Axis, directions_of
from cable_tracker.survey.routes.dive_route import DiveRoute
from cable_tracker.survey.routes.events import HIDDEN_WORDS, Event, EventKind, hidden_detail
from cable_tracker.survey.routes.route import SPACING

LEAST_OVERLAP = 5.0
"""Dives that share a shorter stretch are not of one route [m]."""

DISAGREEMENT = 10.8
"""Chi square of one degree of freedom that sound dives exceed once in a thousand times."""

LEAST_DISAGREEMENT = 2.0
"""Dives that disagree over a shorter stretch are no event [m]."""


SAME_EVENT = 3.0
"""Events of one kind in several dives are one if their beginnings and their ends are so near [m],
or if they share `SAME_SHARE` of the longer one."""

SAME_SHARE = 0.5
"""Least common share of the longer of two events that are one."""


@dataclass(frozen=True, slots=True, eq=False)
class PlacedRoute:
    """A dive's route with its events, in a frame that it shares with others.

    Attributes
    ----------
    recording : str
        Name of the dive.
    route : DiveRoute
        Route in the common frame.
    events : tuple of Event
        Events along the route.
    """

    recording: str
    route: DiveRoute
    events: tuple[Event, ...]


@dataclass(frozen=True, slots=True, eq=False)
class MergedRoute:
    """Route of the cable merged from all dives; columns with one value for each point.

    Attributes
    ----------
    along : FloatArray
        Arc length from the beginning [m].
    places : FloatArray
        x, y, shape (N, 2) [m].
    headings : FloatArray
        Directions of the cable from +x [rad].
    sigmas : FloatArray
        Standard deviation across the cable [m].
    visible : FloatArray
        Share of the dives' routes in which the cable is visible, 0 to 1; NaN where unknown.
    diameters, asides : FloatArray
        Means over the dives' routes of the cable's diameter, and of how far beside it the vehicle
        was, on whichever side [m]; NaN where unknown.
    dives : FloatArray
        Number of dives that observed each point, shape (N,).
    events : tuple of Event
        Events along the route.
    recordings : tuple of str
        Names of the dives.
    """

    along: FloatArray
    places: FloatArray
    headings: FloatArray
    sigmas: FloatArray
    visible: FloatArray
    diameters: FloatArray
    asides: FloatArray
    dives: FloatArray
    events: tuple[Event, ...]
    recordings: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _RouteOnAxis:
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
    """Weighted mean of the routes at N points of an axis.

    Attributes
    ----------
    asides : FloatArray
        Mean lateral offset from the axis, to the left, shape (N,) [m]; 0 where no route counts.
    sigmas : FloatArray
        Standard deviation of the mean, shape (N,) [m]; interpolated where no route counts.
    counts : IndexArray
        Number of routes that count, shape (N,).
    excess : FloatArray
        Chi square per degree of freedom, shape (N,); above 1 where routes are farther apart than
        their standard deviations say.
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
        axis, begin = Axis(left[0].route.places, left[0].route.total_sigmas), 0
        group, left = [left[0]], left[1:]
        # What prolongs the axis may bring others within reach.
        while True:
            near = [each for each in left if axis.overlap(each.route) >= LEAST_OVERLAP]
            if not near:
                break
            for each in near:
                axis, added = axis.extended(each.route)
                begin += added
            group += near
            left = [each for each in left if each not in near]
        for number, each in enumerate(group[1:], start=1):
            departed = _departed(axis, each)
            group[number] = _without(each, departed)
            left += departed
        merged.append(_merged(axis, begin, group))
    return merged


def _departed(axis: Axis, placed: PlacedRoute) -> list[PlacedRoute]:
    """Return the stretches on which a dive has left an axis, with their events."""
    route = placed.route
    away = ~axis.is_along(route, *axis.coordinates(route.places))
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


def _on_axis(axis: Axis, placed: PlacedRoute, begin: int | None) -> _RouteOnAxis:
    """Return a route at the points of an axis.

    `begin` is the index of its first point on an axis that was made of it, which counts all along;
    None for other routes.
    """
    route, is_axis = placed.route, begin is not None
    if begin is None:
        all_along, aside = axis.coordinates(route.places)
    else:
        # Not looked for: a cable that crosses itself comes near to itself.
        count = len(route.along)
        all_along, aside = begin + np.arange(count, dtype=np.float64), np.zeros(count)
    order = np.argsort(all_along, kind="stable")
    along, asked = all_along[order], np.arange(len(axis.points), dtype=np.float64)
    reaches = (asked >= along[0] - 0.5) & (asked <= along[-1] + 0.5)
    visible, unjudged = (x.astype(float) for x in (route.visible(), route.unjudged()))

    def interpolated_at(values: FloatArray) -> FloatArray:
        found = np.interp(asked, along, values[order])
        return np.where(reaches, found, np.nan)

    of_one_cable = is_axis | axis.is_along(route, all_along, aside)[order]
    counts = reaches & (np.interp(asked, along, of_one_cable) == 1.0)

    def of_the_cable(values: FloatArray) -> FloatArray:
        return np.where(counts, interpolated_at(values), np.nan)

    return _RouteOnAxis(
        placed.recording,
        all_along,
        interpolated_at(aside),
        counts,
        interpolated_at(route.total_sigmas**2),
        np.where(
            counts & ~(interpolated_at(unjudged) > 0.5), interpolated_at(visible) > 0.5, np.nan
        ),
        of_the_cable(route.diameters),
        of_the_cable(np.abs(route.asides)),
    )


def _merged(of_group: Axis, begin: int, group: Sequence[PlacedRoute]) -> MergedRoute:
    """Merge a group; from its point number `begin` on, the axis is the first one's route."""
    axis = of_group.points
    beside = [_on_axis(of_group, each, begin if each is group[0] else None) for each in group]
    counts = np.array([each.counts for each in beside])
    asides = np.where(counts, [each.asides for each in beside], np.nan)
    mean = _weighted_mean(asides, np.array([each.variances for each in beside]))
    directions = directions_of(axis)
    normal = np.column_stack((-directions[:, 1], directions[:, 0]))
    places = axis + mean.asides[:, None] * normal
    recordings = [each.recording for each in beside]
    coverage = _coverage(recordings, asides)
    merged = MergedRoute(
        along=np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T)))),
        places=places,
        headings=np.unwrap(np.arctan2(*directions_of(places).T[::-1])),
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
    events = [*_merged_events(merged, group, [each.along for each in beside]), *disagreements]
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


def _merged_events(
    route: MergedRoute, group: Sequence[PlacedRoute], along_axis: Sequence[FloatArray]
) -> list[Event]:
    """Take the events of all dives to the merged route; what was seen several times is one.

    `along_axis` holds the arc lengths of the dives' own points along the axis, in points.
    """
    seen: list[tuple[int, Event]] = []
    points = np.arange(len(route.along))
    for number, (placed, along) in enumerate(zip(group, along_axis, strict=True)):
        for event in placed.events:
            ends = np.interp([event.along, event.end], placed.route.along, along)
            start, end = np.interp(ends, points, route.along).tolist()
            told = event if start <= end else event.reversed()
            start, end = sorted((start, end))
            x, y = interpolated(start, route.along, route.places).tolist()
            seen.append((number, replace(told, along=start, end=end, place=(x, y))))
    return _joined_events(route, sorted(seen, key=lambda each: (each[1].kind.value, each[1].along)))


def _joined_events(route: MergedRoute, events: Sequence[tuple[int, Event]]) -> list[Event]:
    """Join events (number of the dive, event): each dive has seen one once."""
    groups: list[list[tuple[int, Event]]] = []
    for number, event in events:
        for group in reversed(groups[-4:]):
            is_other_dive = all(number != each for each, _ in group)
            if is_other_dive and _is_same_event(event, [each for _, each in group]):
                group.append((number, event))
                break
        else:
            groups.append([(number, event)])
    return [_joined_event(route, [event for _, event in group]) for group in groups]


def _is_same_event(event: Event, group: Sequence[Event]) -> bool:
    """Tell whether an event is the one that several dives saw."""
    if group[0].kind is not event.kind:
        return False
    start, end = _span_of(group)
    shared = min(end, event.end) - max(start, event.along)
    off = max(abs(event.along - start), abs(event.end - end))
    return off <= SAME_EVENT or shared >= SAME_SHARE * max(end - start, event.end - event.along)


def _span_of(group: Sequence[Event]) -> tuple[float, float]:
    """Return from where to where an event goes that several dives saw [m]."""
    along = float(np.median([each.along for each in group]))
    return along, max(along, float(np.median([each.end for each in group])))


def _joined_event(route: MergedRoute, group: Sequence[Event]) -> Event:
    """Put an event that several dives saw together; the dive nearest to its beginning shows it."""
    if len(group) == 1:
        return group[0]
    along, end = _span_of(group)
    x, y = interpolated(along, route.along, route.places).tolist()
    nearest = min(group, key=lambda each: abs(each.along - along))
    others = tuple(sorted({each.recording for each in group} - {nearest.recording}))
    is_hidden = nearest.kind in HIDDEN_WORDS
    detail = hidden_detail(nearest.kind, end - along) if is_hidden else nearest.detail
    return replace(nearest, along=along, end=end, place=(x, y), detail=detail, others=others)
