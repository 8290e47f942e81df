"""Routes of dives in a common frame, for tests of what becomes of several."""

from dataclasses import fields, replace
from functools import cache
from itertools import pairwise

import numpy as np
from survey_dives import Plan, make_dive

from cable_tracker.survey.recording import SurveySettings, analyse
from cable_tracker.survey.routes.dive_route import PROFILE_SPACING, Profile
from cable_tracker.survey.routes.merging import PlacedRoute
from cable_tracker.survey.routes.route import SPACING


@cache
def route_of(plan: Plan) -> PlacedRoute:
    surveyed, _ = analyse(make_dive(plan), SurveySettings())
    (only,) = surveyed.routes
    return only


def placed(plan: Plan, name: str, shift: float = 0.0, sigma: float = 0.05) -> PlacedRoute:
    """Return a dive's route as if it lay on the earth, shifted to the left, with a doubt."""
    only = route_of(plan)
    route = only.route
    normal = np.column_stack((-np.sin(route.headings), np.cos(route.headings)))
    moved = replace(
        route,
        places=route.places + shift * normal,
        frame_variances=np.full(len(route.along), sigma**2),
    )
    return PlacedRoute(name, moved, tuple(replace(e, recording=name) for e in only.events))


def straight(name: str, start: tuple[float, float], end: tuple[float, float]) -> PlacedRoute:
    """Return a dive's route along a straight line."""
    (first, last), kind = np.array([start, end]), placed(Plan(bend=0.0, length=10.0), name)
    count = round(float(np.hypot(*(last - first))) / SPACING) + 1
    only = kind.route
    columns = {
        each.name: np.full(count, getattr(only, each.name)[5])
        for each in fields(only)
        if each.name not in ("start", "profile", "places")
    }
    columns["along"] = np.arange(count) * SPACING
    columns["headings"] = np.full(count, np.arctan2(*(last - first)[::-1]))
    bins = round(count * SPACING / PROFILE_SPACING)
    profile = Profile(0.0, np.full(bins, 3.0), np.ones(bins, bool), np.zeros(bins, bool))
    places = np.linspace(first, last, count)
    return PlacedRoute(name, replace(only, places=places, profile=profile, **columns), ())


def joined(name: str, *corners: tuple[float, float]) -> PlacedRoute:
    """Return a dive's route along straight lines from corner to corner."""
    parts = [straight(name, *ends).route.places for ends in pairwise(corners)]
    places = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
    route = straight(name, (0.0, 0.0), ((len(places) - 1) * SPACING, 0.0)).route
    return PlacedRoute(name, replace(route, places=places), ())
