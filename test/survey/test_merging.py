from dataclasses import replace

import numpy as np
import pytest
from survey_dives import Plan, make_dive

from cable_tracker.survey.events import EventKind
from cable_tracker.survey.merging import PlacedRoute, merge
from cable_tracker.survey.recording import SurveySettings, analyse


def placed(plan: Plan, name: str, shift: float = 0.0, sigma: float = 0.05) -> PlacedRoute:
    """Return a dive's route as if it lay on the earth, shifted to the left, with a doubt."""
    surveyed, _ = analyse(make_dive(plan), SurveySettings())
    (only,) = surveyed.routes
    route = only.route
    normal = np.column_stack((-np.sin(route.headings), np.cos(route.headings)))
    moved = replace(
        route,
        places=route.places + shift * normal,
        frame_variances=np.full(len(route.along), sigma**2),
    )
    return PlacedRoute(name, moved, tuple(replace(e, recording=name) for e in only.events))


def test_two_dives_give_one_route_between_them_weighted_by_their_doubt():
    first = placed(Plan(seed=1), "a", shift=0.06, sigma=0.05)
    second = placed(Plan(seed=2), "b", shift=-0.06, sigma=0.1)
    (merged,) = merge([first, second])
    alone = merge([placed(Plan(seed=1), "c")])[0]
    count = min(len(merged.along), len(alone.along)) - 2
    normal = np.column_stack((-np.sin(alone.headings), np.cos(alone.headings)))
    off = ((merged.places[:count] - alone.places[:count]) * normal[:count]).sum(axis=1)
    # 0.8 of the weight is the first dive's.
    assert np.median(off) == pytest.approx(0.8 * 0.06 - 0.2 * 0.06, abs=0.02)
    assert np.median(merged.sigmas) < 0.055
    assert merged.recordings == ("a", "b")


def test_dives_that_disagree_are_an_event_and_less_sure():
    (merged,) = merge([placed(Plan(), "a", 0.5, 0.02), placed(Plan(seed=2), "b", -0.5, 0.02)])
    (event,) = [each for each in merged.events if each.kind is EventKind.DISAGREEMENT]
    assert "1.0" in event.detail or "0.9" in event.detail
    assert np.median(merged.sigmas) > 0.2


def test_dives_of_different_places_stay_apart():
    far = placed(Plan(), "b")
    shifted = replace(far.route, places=far.route.places + np.array([0.0, 500.0]))
    assert len(merge([placed(Plan(), "a"), replace(far, route=shifted)])) == 2


def test_a_dive_that_goes_on_prolongs_the_route():
    first = placed(Plan(length=40.0), "a")
    second = placed(Plan(length=40.0, seed=3), "b")
    (wave,) = [30.0]
    ahead = replace(second.route, places=second.route.places + np.array([wave, 0.0]))
    (merged,) = merge([first, replace(second, route=ahead)])
    assert merged.along[-1] == pytest.approx(40.0 + wave, rel=0.05)


def test_a_dive_the_other_way_round_is_of_the_same_route():
    back = placed(Plan(seed=2), "b")
    r = back.route
    turned = replace(r, places=r.places[::-1].copy(), headings=r.headings[::-1] + np.pi)
    (merged,) = merge([placed(Plan(), "a"), replace(back, route=turned, events=())])
    assert merged.recordings == ("a", "b")


def test_a_burial_that_two_dives_saw_is_one_event():
    plan = Plan(hidden=((15.0, 21.0),))
    (merged,) = merge([placed(plan, "a"), placed(replace(plan, seed=2), "b")])
    (event,) = [each for each in merged.events if each.kind is EventKind.BURIED]
    assert set(event.recording.split(", ")) == {"a", "b"}
