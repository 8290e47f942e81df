"""Routes of dives in a common frame, and the route merged from those over one cable."""

from __future__ import annotations

from dataclasses import dataclass

from cable_tracker.arrays import FloatArray
from cable_tracker.survey.routes.dive_route import DiveRoute
from cable_tracker.survey.routes.events import Event


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
