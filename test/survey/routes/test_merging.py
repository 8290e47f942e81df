from dataclasses import fields, replace

import numpy as np
import pytest
from placed_routes import joined, placed, straight
from survey_dives import Plan

from cable_tracker.survey.routes.events import Event, EventKind
from cable_tracker.survey.routes.merging import merge


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


def test_a_dive_that_went_along_a_cable_twice_counts_once():
    there, back, other = (placed(Plan(seed=seed), name) for seed, name in enumerate("aab", 1))
    (twice,) = merge([there, back])
    assert twice.recordings == ("a",)
    assert twice.dives.max() == 1.0
    (merged,) = merge([there, back, other])
    assert merged.recordings == ("a", "b")
    assert merged.dives.max() == 2.0


def test_a_dive_that_disagrees_with_itself_is_named_once():
    (merged,) = merge([placed(Plan(), "a", 0.5, 0.02), placed(Plan(seed=2), "a", -0.5, 0.02)])
    (event,) = [each for each in merged.events if each.kind is EventKind.DISAGREEMENT]
    assert event.recordings == "a"


def test_only_dives_that_were_there_disagree():
    first, second = placed(Plan(), "a", 0.5, 0.02), placed(Plan(seed=2), "b", -0.5, 0.02)
    points = int(np.searchsorted(second.route.along, second.route.along[-1] - 12.0))
    there = {
        each.name: value[:points]
        for each in fields(second.route)
        if np.shape(value := getattr(second.route, each.name))[:1] == second.route.along.shape
    }
    shorter = replace(second, route=replace(second.route, **there), events=())
    third = placed(Plan(length=80.0), "c", 0.5, 0.02)
    (merged,) = merge([first, shorter, third])
    disagree = [each for each in merged.events if each.kind is EventKind.DISAGREEMENT]
    beyond = [each for each in disagree if each.along > first.route.along[-1]]
    assert disagree and not beyond
    assert {each.recordings for each in disagree} == {"c, a, b"}


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


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_dives_over_cables_that_cross_stay_apart(turn):
    first = straight("a", (0.0, 0.0), (100.0, 0.0))
    second = straight("b", (50.0, -40.0 * turn), (50.0, 40.0 * turn))
    one, other = merge([first, second])
    assert (one.recordings, other.recordings) == (("a",), ("b",))
    assert np.abs(one.places[:, 1]).max() < 1e-9
    assert np.abs(other.places[:, 0] - 50.0).max() < 1e-9


@pytest.mark.parametrize("length", [80.0, 120.0])
def test_whether_two_dives_are_of_one_cable_does_not_depend_on_which_is_longer(length):
    unsure = straight("a", (0.0, 0.0), (100.0, 0.0))
    doubt = np.full_like(unsure.route.sigmas, 25.0)
    unsure = replace(unsure, route=replace(unsure.route, frame_variances=doubt))
    (merged,) = merge([unsure, straight("b", (0.0, 8.0), (length, 8.0))])
    assert merged.recordings == (("a", "b") if length < 100.0 else ("b", "a"))


def test_short_ways_side_by_side_here_and_there_are_no_common_route():
    zigzag = [(3.0, 0.0), (3.0, 20.0), (6.0, 20.0), (6.0, 0.0), (9.0, 0.0), (9.0, 20.0)]
    dives = [straight("a", (0.0, 0.0), (100.0, 0.0)), joined("b", (0.0, 0.0), *zigzag)]
    assert len(merge(dives)) == 2


def test_a_dive_that_leaves_for_another_cable_does_not_bend_the_route():
    first = straight("a", (0.0, 0.0), (120.0, 0.0))
    second = joined("b", (0.0, 0.2), (40.0, 0.2), (70.0, 30.0), (95.0, 30.0))
    merged, left = merge([first, second])
    beyond = merged.places[:, 0] > 42.0
    assert np.abs(merged.places[beyond, 1]).max() < 1e-9
    assert (merged.dives[beyond] == 1.0).all()
    assert merged.places[merged.places[:, 0] < 35.0, 1] == pytest.approx(0.1, abs=0.02)
    assert left.recordings == ("b",)
    assert left.places[0] == pytest.approx([40.0, 0.2], abs=1.0)
    assert left.places[-1] == pytest.approx([95.0, 30.0])


def test_what_a_dive_saw_where_it_has_left_the_route_is_there_and_not_on_the_route():
    first = straight("a", (0.0, 0.0), (100.0, 0.0))
    second = joined("b", (20.0, 0.0), (60.0, 0.0), (90.0, 30.0), (105.0, 30.0))
    end, place = float(second.route.along[-1]), (105.0, 30.0)
    seen = Event(EventKind.BURIED, end - 3.0, end - 1.0, place, 1, 7, "seen", "b")
    merged, left = merge([first, replace(second, events=(seen,))])
    assert merged.along[-1] == pytest.approx(100.0)
    assert merged.events == ()
    assert [each.kind for each in left.events] == [EventKind.BURIED]
    assert left.along[-1] == pytest.approx(end - 40.0, abs=1.0)


@pytest.mark.parametrize(
    "corners",
    [
        [(0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (30.0, 40.0), (30.0, -40.0)],
        [(0.0, 0.0), (50.0, 0.0), (50.0, 1.0), (0.0, 1.0)],
    ],
    ids=["crosses itself", "comes back beside itself"],
)
def test_a_dive_alone_is_not_bent_where_its_cable_comes_near_to_itself(corners):
    only = joined("a", *corners)
    early = Event(EventKind.BURIED, 5.0, 6.0, (5.0, 0.0), 1, 7, "seen", "a")
    (merged,) = merge([replace(only, events=(early,))])
    assert merged.places == pytest.approx(only.route.places, abs=1e-9)
    (event,) = merged.events
    assert (event.along, event.end) == pytest.approx((5.0, 6.0))


def test_a_burial_that_two_dives_saw_is_one_event():
    plan = Plan(hidden=((15.0, 21.0),))
    (merged,) = merge([placed(plan, "a"), placed(replace(plan, seed=2), "b")])
    (event,) = [each for each in merged.events if each.kind is EventKind.BURIED]
    assert {event.recording, *event.others} == {"a", "b"}


def test_an_event_that_two_dives_saw_lies_on_the_route_where_it_begins():
    first = straight("a", (0.0, 0.0), (100.0, 0.0))
    second = straight("b", (0.0, 0.0), (100.0, 0.0))
    long = Event(EventKind.BURIED, 0.0, 60.0, (0.0, 0.0), 1, 7, "seen", "a")
    short = Event(EventKind.BURIED, 30.0, 70.0, (30.0, 0.0), 1, 7, "seen", "b")
    (merged,) = merge([replace(first, events=(long,)), replace(second, events=(short,))])
    (event,) = merged.events
    assert (event.along, event.end) == pytest.approx((15.0, 65.0), abs=0.1)
    assert event.detail == "not to be seen over 50.0 m"
    assert event.place == pytest.approx((event.along, 0.0), abs=1e-6)


@pytest.mark.parametrize(
    ("other", "count"),
    [((10.0, 14.5), 2), ((6.0, 20.0), 1), ((26.0, 44.0), 2), ((8.5, 32.0), 1), ((5.0, 17.9), 2)],
)
def test_stretches_of_which_dives_share_less_than_half_are_not_one(other, count):
    stretches = {"a": (6.0, 30.0), "b": other}
    dives = [
        replace(
            straight(name, (0.0, 0.0), (100.0, 0.0)),
            events=(Event(EventKind.BURIED, *ends, (ends[0], 0.0), 1, 7, "seen", name),),
        )
        for name, ends in stretches.items()
    ]
    (merged,) = merge(dives)
    assert len(merged.events) == count
    if count == 2:
        found = {each.recording: (each.along, each.end) for each in merged.events}
        assert found == {name: pytest.approx(ends) for name, ends in stretches.items()}


@pytest.mark.parametrize(("place", "count"), [(22.0, 1), (25.0, 2)])
def test_points_that_are_near_are_one_event(place, count):
    dives = [
        replace(
            straight(name, (0.0, 0.0), (100.0, 0.0)),
            events=(Event(EventKind.CROSSING, at, at, (at, 0.0), 1, 7, "seen", name),),
        )
        for name, at in (("a", 20.0), ("b", place))
    ]
    (merged,) = merge(dives)
    assert len(merged.events) == count
    assert {each.detail for each in merged.events} == {"seen"}


def test_what_a_dive_the_other_way_saw_is_told_with_the_picture_of_its_beginning_on_the_route():
    seen = Event(EventKind.BURIED, 10.0, 50.0, (80.0, 0.0), 1, 20, "seen", "b", (), 9, 60)
    back = straight("b", (90.0, 0.0), (10.0, 0.0))
    (merged,) = merge([straight("a", (0.0, 0.0), (100.0, 0.0)), replace(back, events=(seen,))])
    (event,) = merged.events
    assert (event.along, event.end) == pytest.approx((40.0, 80.0))
    assert (event.stamp, event.frame, event.end_stamp, event.end_frame) == (9, 60, 1, 20)


def test_what_a_dive_saw_on_the_way_there_and_back_is_one_event():
    there, back = straight("a", (0.0, 0.0), (100.0, 0.0)), straight("a", (90.0, 0.0), (10.0, 0.0))
    first = Event(EventKind.BURIED, 40.0, 46.0, (40.0, 0.0), 1, 7, "seen", "a", (), 2, 8)
    again = Event(EventKind.BURIED, 44.0, 50.0, (46.0, 0.0), 3, 9, "seen", "a", (), 4, 10)
    (merged,) = merge([replace(there, events=(first,)), replace(back, events=(again,))])
    (event,) = merged.events
    assert (event.along, event.end) == pytest.approx((40.0, 46.0))
    assert event.recordings == "a"
