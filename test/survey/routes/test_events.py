import math
from dataclasses import replace

import numpy as np
import pytest
from survey_dives import DISK, Plan, make_dive, poses_of

from cable_tracker.errors import ParameterError
from cable_tracker.survey.forward_pass import ForwardDive
from cable_tracker.survey.frame_table import EMPTY, REFUSED, TRACKING, CrossingObservation
from cable_tracker.survey.keyframes import make_keyframes
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.recording import SurveySettings, analyse
from cable_tracker.survey.routes.events import EventKind, Limits, hidden_stretches
from cable_tracker.survey.routes.merging import merge
from cable_tracker.survey.routes.route import make_routes
from cable_tracker.survey.smoother import smooth


def events(dive: ForwardDive, kind: EventKind):
    surveyed, _ = analyse(dive, SurveySettings())
    return [each for placed in surveyed.routes for each in placed.events if each.kind is kind]


def test_a_dive_without_anything_odd_has_no_events_but_that_it_was_found():
    surveyed, _ = analyse(make_dive(Plan()), SurveySettings())
    (placed,) = surveyed.routes
    assert [event.kind for event in placed.events] == [EventKind.FOUND]


def test_the_ends_of_a_buried_stretch_are_known_to_a_few_decimetres():
    (event,) = events(make_dive(Plan(hidden=((15.0, 21.0),))), EventKind.BURIED)
    # The route begins where the camera looked first.
    assert event.along + 0.7 == pytest.approx(15.0, abs=0.5)
    assert event.end + 0.7 == pytest.approx(21.0, abs=0.5)


@pytest.mark.parametrize("weight", [0.0, 0.01])
def test_what_is_claimed_of_something_else_is_not_seen_as_the_cable(weight):
    dive = make_dive(Plan())
    rows = dive.table.rows
    keyframes = make_keyframes(rows, poses_of(dive).at(rows["stamp"]), DISK)
    cable = smooth(keyframes, DISK)
    other = (cable.along > 15.0) & (cable.along < 25.0)
    weights = np.where(other, weight, cable.weights)
    (route,) = make_routes(keyframes, cable._replace(weights=weights), rows, DISK)
    along = route.profile.along + route.start
    assert np.isnan(route.profile.seen[(along > 17.0) & (along < 23.0)]).all()
    assert np.isfinite(route.profile.seen[(along > 5.0) & (along < 12.0)]).all()


@pytest.mark.parametrize(("in_view", "count"), [(True, 1), (False, 0)])
def test_what_stays_hidden_to_the_end_is_told_if_its_place_is_in_the_pictures(in_view, count):
    surveyed, _ = analyse(make_dive(Plan()), SurveySettings())
    route = surveyed.routes[0].route
    seen, shown = route.profile.seen.copy(), route.profile.in_view.copy()
    seen[-30:], shown[-30:] = 0.0, in_view
    ended = replace(route, profile=replace(route.profile, seen=seen, in_view=shown))
    found = hidden_stretches(ended, 1.0)
    assert len(found) == count
    assert all(end == pytest.approx(route.along[-1], abs=0.2) for _, end, _ in found)


def test_short_gaps_are_no_events():
    assert not events(make_dive(Plan(hidden=((15.0, 15.5),))), EventKind.BURIED)


def test_the_cable_is_lost_and_found_again():
    dive = make_dive(Plan(hidden=((15.0, 21.0),)))
    assert len(events(dive, EventKind.FOUND)) == 2
    assert len(events(dive, EventKind.LOST)) == 1


def test_an_altimeter_that_fails_buries_nothing():
    dive = make_dive(Plan())
    rows, number = dive.table.rows, dive.table.reason_number("unusable altitude")
    failed = slice(300, 360)
    frames, stamps = rows["frame"][failed].copy(), rows["stamp"][failed].copy()
    rows[failed] = EMPTY
    rows["frame"][failed], rows["stamp"][failed] = frames, stamps
    rows["status"][failed], rows["reason"][failed] = TRACKING, number
    surveyed, _ = analyse(dive, SurveySettings())
    (placed,) = surveyed.routes
    found, without = placed.events
    assert (found.kind, without.kind) == (EventKind.FOUND, EventKind.NO_METRES)
    assert without.detail == "unusable altitude"
    assert (without.along, without.end) == pytest.approx((15.0, 18.0), abs=1.5)
    (merged,) = merge(list(surveyed.routes))
    assert np.isnan(merged.visible[(merged.along > 16.2) & (merged.along < 16.8)]).all()


def test_a_vehicle_far_beside_is_out_of_view_and_too_far():
    dive = make_dive(Plan(hidden=((15.0, 21.0),)))
    rows = dive.table.rows
    rows["half_view"] = 0.05
    assert events(dive, EventKind.OUT_OF_VIEW)
    assert not events(dive, EventKind.BURIED)


def test_a_thick_place_is_out_of_the_ordinary():
    dive = make_dive(Plan())
    rows = dive.table.rows
    rows["diameter"][300:360] = 0.3
    (event,) = events(dive, EventKind.WIDTH)
    assert "0.300" in event.detail and event.end - event.along == pytest.approx(2.5, abs=1.0)


def test_a_line_across_that_is_seen_often_is_a_crossing():
    dive = make_dive(Plan())
    for row in range(300, 312):
        ahead = 0.7 + 0.05 * (306 - row)
        dive.table.crossings.append(CrossingObservation(row, ahead, 1.0))
    dive.table.crossings.append(CrossingObservation(100, 0.7, 1.2))
    (event,) = events(dive, EventKind.CROSSING)
    assert event.along == pytest.approx(15.3, abs=0.5)


def test_a_sharp_bend_is_told_with_its_radius():
    dive = make_dive(Plan(bend=0.25, noise=0.005))
    assert any("radius" in event.detail for event in events(dive, EventKind.BEND))


def test_with_a_radius_of_zero_nothing_is_a_bend():
    dive = make_dive(Plan(bend=0.25, noise=0.005))
    settings = SurveySettings(limits=Limits(bend_radius=0.0))
    surveyed, _ = analyse(dive, settings)
    kinds = {event.kind for placed in surveyed.routes for event in placed.events}
    assert EventKind.BEND not in kinds


@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_limits_that_are_no_lengths_are_refused(value):
    with pytest.raises(ParameterError, match="bend-radius"):
        Limits(bend_radius=value)


def test_an_odometry_that_jumps_is_an_event():
    dive = make_dive(Plan())
    stamps, values = dive.poses.arrays()
    values[200:, 0] += 30.0
    again = ForwardDive(dive.name, dive.disk)
    again.table = dive.table
    for stamp, value in zip(stamps, values, strict=True):
        again.poses.add(int(stamp), list(value))
    assert len(events(again, EventKind.NAVIGATION)) == 1


def test_a_jump_of_odometry_is_an_event_of_the_route_that_it_lies_in():
    dive, again = make_dive(Plan()), ForwardDive("dive", DISK)
    stamps, values = dive.poses.arrays()
    values[100:, 0] += 30.0
    silence = (stamps > stamps[400]) & (stamps < stamps[500])
    for stamp, value in zip(stamps[~silence], values[~silence], strict=True):
        again.poses.add(int(stamp), list(value))
    again.table = dive.table
    surveyed, course = analyse(again, SurveySettings())
    assert len(surveyed.routes) == 2 and len(course.trajectory.jumps) == 1
    kinds = [[event.kind for event in placed.events] for placed in surveyed.routes]
    assert EventKind.NAVIGATION in kinds[0] and EventKind.NAVIGATION not in kinds[1]


def dive_in_two_pieces():
    """Return a dive whose odometry is silent and then goes on elsewhere."""
    dive, again = make_dive(Plan()), ForwardDive("dive", DISK)
    stamps, values = dive.poses.arrays()
    silence = (stamps > stamps[400]) & (stamps < stamps[500])
    for stamp, value in zip(stamps[~silence], values[~silence], strict=True):
        again.poses.add(int(stamp), list(value))
    again.table = dive.table
    return again


def test_a_crossing_is_an_event_of_the_route_that_it_was_seen_from():
    dive = dive_in_two_pieces()
    for row in range(500, 508):
        # Just before the place where the second route begins, and the first one has ended.
        dive.table.crossings.append(CrossingObservation(row, 0.5 - 0.05 * (row - 500), 1.0))
    surveyed, _ = analyse(dive, SurveySettings())
    assert len(surveyed.routes) == 2
    first, _ = surveyed.routes
    assert EventKind.CROSSING not in [event.kind for event in first.events]


def test_a_crossing_that_is_seen_while_odometry_is_silent_has_no_place():
    dive = dive_in_two_pieces()
    for row in range(440, 460):
        dive.table.crossings.append(CrossingObservation(row, 0.6 - 0.02 * (row - 440), 1.0))
    assert not events(dive, EventKind.CROSSING)


def test_what_is_seen_while_odometry_is_silent_is_not_seen_where_it_fell_silent():
    dive = dive_in_two_pieces()
    # Were they of the last place that is known, they would outweigh what was seen there.
    dive.table.rows["profile_score"][402:499] = 0.0
    dive.table.rows["diameter"][402:499] = 0.5
    surveyed, _ = analyse(dive, SurveySettings())
    for placed in surveyed.routes:
        assert {event.kind for event in placed.events} <= {EventKind.FOUND}
        assert np.nanmax(placed.route.diameters) < 0.3


@pytest.mark.parametrize("end", [30.0, 30.1, 30.2, 30.3, 30.4])
def test_a_cable_that_ends_before_the_dive_is_lost_there(end):
    (event,) = events(make_dive(Plan(hidden=((end, 60.0),))), EventKind.LOST)
    assert event.along + 0.7 == pytest.approx(end, abs=0.3)


def test_a_cable_that_is_seen_up_to_the_end_is_not_lost_wherever_the_dive_turned_round():
    there = make_dive(Plan(length=20.0))
    stamps, values = there.poses.arrays()
    rows = there.table.rows
    both = ForwardDive(there.name, there.disk)
    order = [*range(len(rows)), *range(len(rows) - 1, len(rows) // 2, -1)]
    for number, k in enumerate(order):
        both.poses.add(int(stamps[0]) + number * 100_000_000, list(values[k]))
        row = both.table.append()
        for name in rows.dtype.names:
            row[name] = rows[name][k]
        row["frame"], row["stamp"] = number, int(stamps[0]) + number * 100_000_000
    assert len(events(both, EventKind.FOUND)) == 1
    assert not events(both, EventKind.LOST)


def test_without_odometry_there_are_times_instead_of_places():
    dive = make_dive(Plan(hidden=((15.0, 21.0),)))
    bare = ForwardDive(dive.name, dive.disk)
    bare.table = dive.table
    surveyed, course = analyse(bare, SurveySettings())
    assert course is None and not surveyed.routes
    assert [event.kind for event in surveyed.events] == [
        EventKind.FOUND, EventKind.LOST, EventKind.FOUND,
    ]  # fmt: skip
    assert any("pixels only" in note for note in surveyed.notes)


@pytest.mark.parametrize("block", [1, 4096])
def test_without_odometry_a_picture_that_is_refused_loses_no_cable(block):
    bare = ForwardDive("dive", Disk(block=block))
    for number, status in enumerate(
        [REFUSED, 0, TRACKING, TRACKING, REFUSED, TRACKING, 2, REFUSED]
    ):
        row = bare.table.append()
        row["frame"], row["stamp"], row["status"] = number, 40_000_000 * number, status
    surveyed, _ = analyse(bare, SurveySettings())
    assert [(event.kind, event.frame) for event in surveyed.events] == [
        (EventKind.FOUND, 2), (EventKind.LOST, 6),
    ]  # fmt: skip


def test_clocks_that_are_far_apart_are_said():
    dive = make_dive(Plan())
    rows = dive.table.rows
    rows["stamp"] += np.int64(3600e9)
    surveyed, _ = analyse(dive, SurveySettings())
    assert not surveyed.routes
    assert any("3600 s apart" in note or "360" in note for note in surveyed.notes)
