"""Events along a route."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from enum import Enum

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, interpolated, true_runs
from cable_tracker.errors import ParameterError
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.survey.forward_pass import ForwardDive
from cable_tracker.survey.frame_table import is_withheld
from cable_tracker.survey.routes.crossings import find_crossings
from cable_tracker.survey.routes.dive_route import PROFILE_SPACING, DiveRoute
from cable_tracker.survey.routes.profile import LEAST_WEIGHT
from cable_tracker.survey.routes.route import SPACING, Course


class EventKind(str, Enum):
    """Kind of an event."""

    FOUND = "found"
    LOST = "lost"
    OUT_OF_VIEW = "out of view"
    BURIED = "buried or overgrown"
    NO_METRES = "claimed without metres"
    WIDTH = "width out of the ordinary"
    CROSSING = "crossing"
    BEND = "bend"
    ASIDE = "vehicle too far beside"
    NAVIGATION = "navigation"
    DISAGREEMENT = "dives disagree"


@dataclass(frozen=True, slots=True)
class Event:
    """One event along a route.

    Attributes
    ----------
    kind : EventKind
        Kind of the event.
    along, end : float
        Arc lengths of its beginning and end along the route [m]; equal for a point.
    place : (float, float)
        x, y of its beginning in the route's frame [m].
    stamp : int
        Time of the keyframe at the beginning, or of the next one beyond [ns]. If several dives saw
        the event, that of the dive whose own beginning of it is nearest to `along`; 0 where dives
        disagree.
    frame : int
        Number of the frame of that time in the recording; -1 without one.
    detail : str
        Description with numbers and units.
    recording : str
        Name of the dive; of several dives, of the one that has the frame.
    others : tuple of str
        Names of the other dives.
    end_stamp, end_frame : int
        Time and frame of its end, as `stamp` and `frame`.
    """

    kind: EventKind
    along: float
    end: float
    place: tuple[float, float]
    stamp: int
    frame: int
    detail: str
    recording: str = ""
    others: tuple[str, ...] = ()
    end_stamp: int = 0
    end_frame: int = -1

    def reversed(self) -> Event:
        """Return the event as a dive along the cable the other way has it."""
        return replace(
            self,
            stamp=self.end_stamp, frame=self.end_frame,
            end_stamp=self.stamp, end_frame=self.frame,
        )  # fmt: skip

    @property
    def recordings(self) -> str:
        """All dives, with commas."""
        return ", ".join((self.recording, *self.others))


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits from which something is an event.

    Attributes
    ----------
    least_burial : float
        Length of the shortest stretch without visible borders that is reported [m].
    bend_radius : float
        Radius below which bends are reported [m]; 0: none.
    most_aside : float
        Distance beside the cable from which on the vehicle is too far from it [m].

    Raises
    ------
    ParameterError
        One is negative or not finite.
    """

    least_burial: float = 1.0
    bend_radius: float = 10.0
    most_aside: float = 1.2

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if not 0.0 <= value < math.inf:
                raise ParameterError(f"{name.replace('_', '-')} is {value:g}: give 0 or more")


MERGED_BURIALS = 0.6
"""Stretches that are nearer to each other are one [m]."""

USUAL_LENGTH = 20.0
"""Length over which the usual diameter is taken [m]."""

WIDTH_SHARE = 0.3
"""Deviation of an unusual diameter from the usual one, as a share."""

LEAST_WIDTH_LENGTH = 1.0
"""Shortest length over which an unusual diameter is reported [m]."""

HIDDEN_WORDS = {
    EventKind.BURIED: "not to be seen",
    EventKind.OUT_OF_VIEW: "outside the pictures",
}
"""What is said of stretches on which the cable is hidden."""

LEAST_ASIDE_LENGTH = 1.0
"""Excursions over a shorter length are not reported [m]."""

LEAST_LOST = 1.0
"""Silence over a shorter length is no event [m]."""

JUMP_REACH = 3.0
"""Time before the first and after the last point of a route in which a jump of odometry belongs to
it [s]: a route begins and ends where the look line is, beside its first and its last claim."""

SURE = 2.0
"""Excess of a bend over the limit that makes it an event [standard deviations]."""


def find_events(dive: ForwardDive, course: Course, route: DiveRoute, limits: Limits) -> list[Event]:
    """Return the events of one route of a dive, by their place."""
    maker = _EventMaker(dive, course, route)
    events = [
        *_found_and_lost(maker),
        *_hidden(maker, limits),
        *_without_metres(maker),
        *_widths(maker),
        *_bends(maker, limits),
        *_asides(maker, limits),
        *_crossings(maker),
        *_navigation(maker),
    ]
    dive.disk.release_pages()
    return sorted(events, key=lambda event: (event.along, event.kind.value))


class _EventMaker:
    """Makes events at places of a route; `piece` is the number of its connected piece.

    The arc length along the cable of the next piece begins where the one before ends.
    """

    def __init__(self, dive: ForwardDive, course: Course, route: DiveRoute) -> None:
        self.dive, self.course, self.route = dive, course, route
        self.piece = int(course.cable.piece[course.keyframes.of(route.rows[:1])[0]])

    def at(self, kind: EventKind, along: float, detail: str, end: float | None = None) -> Event:
        route = self.route
        along = float(np.clip(along, 0.0, route.along[-1]))
        end = along if end is None else float(np.clip(end, along, route.along[-1]))
        x, y = interpolated(along, route.along, route.places).tolist()
        stamp, frame = self._time_and_frame_at(along)
        end_stamp, end_frame = self._time_and_frame_at(end)
        return Event(
            kind, along, end, (x, y), stamp, frame, detail, self.dive.name, (), end_stamp, end_frame
        )  # fmt: skip

    def _time_and_frame_at(self, along: float) -> tuple[int, int]:
        """Return time [ns] and number of the frame that shows a place of the route."""
        row = int(self.route.rows[min(round(along / SPACING), len(self.route.along) - 1)])
        rows = self.dive.table.rows
        found = int(rows["stamp"][row]), int(rows["frame"][row])
        self.dive.disk.release_pages()
        return found


def _found_and_lost(maker: _EventMaker) -> list[Event]:
    route, cable, disk = maker.route, maker.course.cable, maker.dive.disk
    along = disk.filled(len(cable.along), lambda part: cable.along[part] - route.start)
    end = int(np.searchsorted(cable.piece, maker.piece, "right"))
    rows, first_rows = maker.dive.table.rows, maker.course.keyframes.first

    def claimed(part: slice) -> BoolArray:
        inside = (along[part] >= -0.5) & (along[part] <= route.along[-1] + 0.5)
        inside &= cable.piece[part] == maker.piece
        counts = cable.weights[part] > LEAST_WEIGHT
        found: BoolArray = inside & (counts | is_withheld(rows[first_rows[part]]))
        return found

    def goes_on(after: int) -> bool:
        rest = disk.blocks(end, after)
        return any(np.abs(along[part] - along[after - 1]).max() >= LEAST_LOST for part in rest)

    events: list[Event] = []
    for first, last in _long_claims(disk.filled(len(along), claimed, np.bool_), along):
        start = float(along[first])
        events.append(maker.at(EventKind.FOUND, start, "the tracker claims the cable"))
        if goes_on(last):
            detail = "from here on no claims, or only such as disagree with the route"
            events.append(maker.at(EventKind.LOST, float(along[last - 1]), detail))
    return events


def _long_claims(claimed: BoolArray, along: FloatArray) -> list[tuple[int, int]]:
    """Return runs of claims; silence over a short length does not end one."""
    return _joined_runs(
        claimed, lambda end, first: bool(abs(along[first] - along[end - 1]) < LEAST_LOST)
    )


def _joined_runs(mask: BoolArray, are_one: Callable[[int, int], bool]) -> list[tuple[int, int]]:
    """Return first and last + 1 of each run of True in a mask (N,), some of them joined.

    `are_one` tells, from the last + 1 of a run and the first of the next, whether to join the two.
    """
    joined: list[tuple[int, int]] = []
    for first, last in true_runs(mask):
        if joined and are_one(joined[-1][1], first):
            joined[-1] = (joined[-1][0], last)
        else:
            joined.append((first, last))
    return joined


def hidden_stretches(route: DiveRoute, least: float) -> list[tuple[float, float, bool]]:
    """Return where the cable cannot be seen: from, to [m], and whether it was in view at all."""
    profile = route.profile
    along = profile.along
    gap = round(MERGED_BURIALS / PROFILE_SPACING)
    found = []
    hidden = ~profile.visible & ~profile.unjudged
    for first, last in _joined_runs(hidden, lambda end, first: first - end < gap):
        length = (last - first) * PROFILE_SPACING
        was_in_view = bool(profile.in_view[first:last].mean() >= 0.5)
        # Before a route begins and after it ends, any cable is outside the pictures.
        at_the_end = first == 0 or last == len(along)
        if length < least or (at_the_end and not was_in_view):
            continue
        half = PROFILE_SPACING / 2
        found.append((float(along[first]) - half, float(along[last - 1]) + half, was_in_view))
    return found


def _hidden(maker: _EventMaker, limits: Limits) -> list[Event]:
    events = []
    for start, end, was_in_view in hidden_stretches(maker.route, limits.least_burial):
        kind = EventKind.BURIED if was_in_view else EventKind.OUT_OF_VIEW
        events.append(maker.at(kind, start, hidden_detail(kind, end - start), end))
    return events


def hidden_detail(kind: EventKind, length: float) -> str:
    """Describe a stretch of a length [m] on which the cable is hidden."""
    return f"{HIDDEN_WORDS[kind]} over {length:.1f} m"


def _without_metres(maker: _EventMaker) -> list[Event]:
    """Return where the tracker claims the cable, but no instrument tells where that is."""
    route, table = maker.route, maker.dive.table

    def detail(stretch: slice) -> str:
        first, last = sorted((int(route.rows[stretch.start]), int(route.rows[stretch.stop - 1])))
        rows = table.rows[first : last + 1]
        reasons = rows["reason"][is_withheld(rows)]
        return table.reasons[int(np.bincount(reasons).argmax())] if len(reasons) else ""

    return _stretches(maker, EventKind.NO_METRES, route.unjudged(), LEAST_LOST, detail)


def _widths(maker: _EventMaker) -> list[Event]:
    route = maker.route
    diameters = np.where(route.visible(), route.diameters, np.nan)
    known = np.isfinite(diameters)
    if known.sum() < 2 * LEAST_WIDTH_LENGTH / SPACING:
        return []
    half = round(USUAL_LENGTH / SPACING / 2)
    usual = np.array(
        [
            np.nanmedian(diameters[max(0, k - half) : k + half + 1])
            if known[max(0, k - half) : k + half + 1].any()
            else np.nan
            for k in range(len(diameters))
        ]
    )
    with np.errstate(invalid="ignore"):
        odd = known & (np.abs(diameters - usual) > WIDTH_SHARE * usual)

    def detail(stretch: slice) -> str:
        value, normal = float(np.median(diameters[stretch])), float(usual[stretch.start])
        return f"diameter {value:.3f} m, usually {normal:.3f} m"

    return _stretches(maker, EventKind.WIDTH, odd, LEAST_WIDTH_LENGTH, detail)


def _bends(maker: _EventMaker, limits: Limits) -> list[Event]:
    route = maker.route
    sharp = (np.abs(route.bends) - SURE * route.bend_sigmas) * limits.bend_radius > 1.0

    def detail(stretch: slice) -> str:
        return f"radius down to {1.0 / float(np.abs(route.bends[stretch]).max()):.1f} m"

    return _stretches(maker, EventKind.BEND, sharp, 0.0, detail)


def _asides(maker: _EventMaker, limits: Limits) -> list[Event]:
    asides = np.abs(maker.route.asides)

    def detail(stretch: slice) -> str:
        return f"up to {float(asides[stretch].max()):.1f} m beside the cable"

    return _stretches(
        maker, EventKind.ASIDE, asides > limits.most_aside, LEAST_ASIDE_LENGTH, detail
    )


def _stretches(
    maker: _EventMaker,
    kind: EventKind,
    mask: BoolArray,
    least: float,
    detail: Callable[[slice], str],
) -> list[Event]:
    """Return an event for each run of a mask over the route's points, from a length on [m]."""
    along = maker.route.along
    return [
        maker.at(kind, float(along[first]), detail(slice(first, last)), float(along[last - 1]))
        for first, last in true_runs(mask)
        if (last - 1 - first) * SPACING >= least
    ]


def _crossings(maker: _EventMaker) -> list[Event]:
    events = []
    for each in find_crossings(maker.dive, maker.course, maker.route.start, maker.piece):
        if 0.0 <= each.along <= maker.route.along[-1]:
            angle = f"{math.degrees(each.across):.0f} deg"
            detail = f"another line at {angle}, seen in {each.pictures} pictures"
            events.append(maker.at(EventKind.CROSSING, each.along, detail))
    return events


def _navigation(maker: _EventMaker) -> list[Event]:
    route = maker.route
    reach = round(JUMP_REACH * NANOSECONDS)
    earliest, latest = int(route.stamps.min()) - reach, int(route.stamps.max()) + reach
    events = []
    for stamp in maker.course.trajectory.jumps:
        if not earliest <= stamp <= latest:
            continue
        point = int(np.abs(route.stamps - stamp).argmin())
        detail = "odometry restarted or its clock jumped; the trajectory was joined here"
        events.append(maker.at(EventKind.NAVIGATION, float(route.along[point]), detail))
    return events
