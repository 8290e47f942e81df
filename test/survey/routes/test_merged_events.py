from dataclasses import replace

import pytest
from placed_routes import placed, straight
from survey_dives import Plan

from cable_tracker.survey.routes.events import Event, EventKind
from cable_tracker.survey.routes.merging import merge


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
