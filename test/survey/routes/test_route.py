"""Routes of dives that leave a straight cable, along y = 0, and come back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from survey_dives import DISK, LOOK, RATE, SPEED, START

from cable_tracker.survey.forward_pass import ForwardDive
from cable_tracker.survey.frame_table import PROFILE_BINS, TRACKING
from cable_tracker.survey.recording import SurveySettings, analyse
from cable_tracker.survey.routes.dive_route import DiveRoute

HALF_VIEW = 1.0
STEP = SPEED / RATE


def legs(corners: Sequence[tuple[float, float]]) -> np.ndarray:
    """Return x, y, yaw of a vehicle that turns on the spot at each corner, (N, 3)."""
    way, yaw = [], 0.0
    for start, end in pairwise(corners):
        step = np.subtract(end, start)
        turn = math.remainder(math.atan2(step[1], step[0]) - yaw, 2 * math.pi)
        turns = np.linspace(yaw, yaw + turn, math.ceil(abs(turn) / 0.05), endpoint=False)
        way.append(np.column_stack((np.tile(start, (len(turns), 1)), turns)))
        yaw += turn
        count = round(np.hypot(*step) / STEP)
        places = start + np.arange(count)[:, None] / count * step
        way.append(np.column_stack((places, np.full(count, yaw))))
    return np.concatenate(way)


def circle(radius: float) -> np.ndarray:
    """Return x, y, yaw along a cable, once round to the right, and on, (N, 3)."""
    angles = np.arange(0.0, 2 * math.pi, STEP / radius)
    places = radius * np.column_stack((np.sin(angles), np.cos(angles) - 1.0))
    round_it = np.column_stack((20.0 + places[:, 0], places[:, 1], -angles))
    return np.concatenate(
        (legs([(0.0, 0.0), (20.0, 0.0)]), round_it, legs([(20.0, 0.0), (40.0, 0.0)]))
    )


def dive_along(way: np.ndarray, look: float = LOOK) -> ForwardDive:
    """Return a dive that claims what its pictures would show of the cable."""
    rng, dive = np.random.default_rng(0), ForwardDive("dive", DISK)
    for number, (x, y, yaw) in enumerate(way.tolist()):
        stamp = START + round(number / RATE * 1e9)
        dive.poses.add(stamp, [x, y, math.remainder(yaw, 2 * math.pi), SPEED])
        row = dive.table.append()
        row["frame"], row["stamp"], row["look"], row["half_view"] = number, stamp, look, HALF_VIEW
        aside = -(y + look * math.sin(yaw)) / math.cos(yaw)
        if abs(math.cos(yaw)) < 0.5 or abs(aside) > HALF_VIEW:
            row["status"] = 2
            continue
        row["status"], row["diameter"] = TRACKING, 0.16
        row["aside"] = aside + 0.005 * rng.standard_normal()
        row["heading"] = math.remainder(-yaw, math.pi) + 0.005 * rng.standard_normal()
        row["aside_variance"], row["aside_heading"], row["heading_variance"] = 4e-4, 0.0, 1e-4
        row["profile_ahead"] = np.linspace(look + 0.8, look - 0.8, PROFILE_BINS)
        row["profile_score"] = 3.0
    return dive


def routes_along(way: np.ndarray, look: float = LOOK) -> list[DiveRoute]:
    surveyed, _ = analyse(dive_along(way, look), SurveySettings())
    return [placed.route for placed in surveyed.routes]


DETOUR = [(0.0, 0.0), (20.0, 0.0), (20.0, 8.0), (60.0, 8.0), (60.0, 0.0), (80.0, 0.0)]
SQUARE = [(0.0, 0.0), (20.0, 0.0), (20.0, 4.0), (16.0, 4.0), (16.0, 0.0), (20.0, 0.0), (40.0, 0.0)]


@pytest.mark.parametrize(
    "way",
    [legs(DETOUR), legs(SQUARE), circle(3.0), circle(5.0)],
    ids=["detour", "square", "circle of 3 m", "circle of 5 m"],
)
def test_a_vehicle_that_turns_away_and_comes_back_makes_up_no_cable(way):
    routes = routes_along(way)
    assert len(routes) == 2
    for route in routes:
        off = np.abs(route.places[:, 1])
        assert off.max() < 0.5
        assert route.along[-1] == pytest.approx(np.ptp(route.places[:, 0]), abs=1.0)
    assert routes[0].places[-1, 0] < 26.0


def test_a_dive_that_comes_to_the_cable_slantwise_has_a_route_of_what_it_claims():
    (route,) = routes_along(legs([(-8.0, -8.0), (0.0, 0.0), (30.0, 0.0)]))
    assert np.abs(route.places[:, 1]).max() < 0.2
    assert route.places[0, 0] > -3.0


@pytest.mark.parametrize("look", [0.0, 0.7, 1.7])
@pytest.mark.parametrize(("beside", "yaw"), [(0.0, 0.35), (0.8, -0.35), (-0.8, 0.35), (0.5, 0.0)])
def test_how_far_beside_the_cable_a_vehicle_is_does_not_depend_on_where_it_looks(look, beside, yaw):
    way = np.column_stack((np.arange(600) * STEP, np.full(600, beside), np.full(600, yaw)))
    (route,) = routes_along(way, look)
    assert route.asides == pytest.approx(np.full(len(route.asides), -beside), abs=0.05)
