"""Events of several dives over one cable put together: what several of them saw is one event."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cable_tracker.arrays import FloatArray, interpolated
from cable_tracker.survey.routes.events import HIDDEN_WORDS, Event, hidden_detail
from cable_tracker.survey.routes.merged_route import MergedRoute, PlacedRoute

SAME_EVENT = 3.0
"""Events of one kind in several dives are one if their beginnings and their ends are so near [m],
or if they share `SAME_SHARE` of the longer one."""

SAME_SHARE = 0.5
"""See `SAME_EVENT`."""


def merged_events(
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
    return _joined(route, sorted(seen, key=lambda each: (each[1].kind.value, each[1].along)))


def _joined(route: MergedRoute, events: Sequence[tuple[int, Event]]) -> list[Event]:
    """Join events (number of the dive, event): each dive has seen one once."""
    groups: list[list[tuple[int, Event]]] = []
    for number, event in events:
        for group in reversed(groups[-4:]):
            is_other_dive = all(number != each for each, _ in group)
            if is_other_dive and _is_same(event, [each for _, each in group]):
                group.append((number, event))
                break
        else:
            groups.append([(number, event)])
    return [_one(route, [event for _, event in group]) for group in groups]


def _is_same(event: Event, group: Sequence[Event]) -> bool:
    """Tell whether an event is the one that several dives saw."""
    if group[0].kind is not event.kind:
        return False
    start, end = _span(group)
    shared = min(end, event.end) - max(start, event.along)
    off = max(abs(event.along - start), abs(event.end - end))
    return off <= SAME_EVENT or shared >= SAME_SHARE * max(end - start, event.end - event.along)


def _span(group: Sequence[Event]) -> tuple[float, float]:
    """Return from where to where an event goes that several dives saw [m]."""
    along = float(np.median([each.along for each in group]))
    return along, max(along, float(np.median([each.end for each in group])))


def _one(route: MergedRoute, group: Sequence[Event]) -> Event:
    """Put an event that several dives saw together; the dive nearest to its beginning shows it."""
    if len(group) == 1:
        return group[0]
    along, end = _span(group)
    x, y = interpolated(along, route.along, route.places).tolist()
    nearest = min(group, key=lambda each: abs(each.along - along))
    others = tuple(sorted({each.recording for each in group} - {nearest.recording}))
    is_hidden = nearest.kind in HIDDEN_WORDS
    detail = hidden_detail(nearest.kind, end - along) if is_hidden else nearest.detail
    return replace(nearest, along=along, end=end, place=(x, y), detail=detail, others=others)
