"""Recordings with something wrong: each is surveyed as far as it goes, and the reason is said."""

from __future__ import annotations

import os
import resource
import shutil
import signal
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rewriting import rewritten, shift

from cable_tracker.campaigns.folder_tasks import TaskState
from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.errors import OutputError, ParameterError
from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings as Simulated
from cable_tracker.simulation.instruments.survey_dive import write_survey_bag
from cable_tracker.survey.campaign import names_of, run_survey
from cable_tracker.survey.forward_pass import ForwardSettings
from cable_tracker.survey.recording import SurveySettings
from cable_tracker.survey.routes.events import EventKind

pytestmark = pytest.mark.slow

ALONE = ClusterSettings()
PLAIN = SurveySettings(pictures=False)


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("bad") / "dive"
    write_survey_bag(path, Simulated(length=4.0, rate=5.0, image_size=(160, 120), current=0.0))
    return path


@pytest.fixture
def surveyed(bag, tmp_path):
    """Survey a bag that was changed; return its row and the whole result."""

    def survey(change):
        path = rewritten(bag, tmp_path / "changed", change)
        result = run_survey([path], tmp_path / "map", PLAIN, ALONE)
        (row,) = result.rows
        return row, result

    return survey


def words_of(row):
    return " ".join((row.state, *row.notes))


def test_mixed_cameras_are_a_failure_that_names_them(surveyed):
    def change(topic, message, time):
        yield topic, message, time
        if topic == "/image":
            yield "/stern/image", message, time

    row, _ = surveyed(change)
    assert row.state.startswith("failed: ")
    assert "/image" in row.state and "/stern/image" in row.state and "--topic" in row.state


def smaller(topic, message, times=2):
    """Make a picture, or a calibration, so many times smaller."""
    if topic.endswith("image"):
        rows = message.data.reshape(message.height, message.width, -1)[::times, ::times]
        message.height, message.width = rows.shape[:2]
        message.step, message.data = rows[0].size, rows.reshape(-1).copy()
    elif topic.endswith("camera_info"):
        message.width, message.height = message.width // times, message.height // times
        scale = np.array([times, 1, times, 1, times, times, 1, 1, 1], float)
        message.k = message.k / scale
        message.p = message.p / np.insert(scale, [3, 6, 9], 1.0)


def test_one_of_two_cameras_of_different_sizes_can_be_chosen(bag, tmp_path):
    def change(topic, message, time):
        yield topic, message, time
        if topic in {"/image", "/camera_info"}:
            other = deepcopy(message)
            smaller(topic, other)
            yield f"/stern{topic}", other, time

    path = rewritten(bag, tmp_path / "both", change)
    routes = []
    for topic in ("/image", "/stern/image"):
        settings = replace(PLAIN, forward=ForwardSettings(topic=topic))
        result = run_survey([path], tmp_path / f"map{len(routes)}", settings, ALONE)
        assert result.rows[0].state == "done"
        routes.append(result.routes[0])
    assert routes[0].places[-1] == pytest.approx(routes[1].places[-1], abs=0.3)


def test_recordings_of_different_cameras_are_one_survey(bag, tmp_path):
    def change(topic, message, time):
        smaller(topic, message)
        yield topic, message, time

    path = rewritten(bag, tmp_path / "small", change)
    result = run_survey([bag, path], tmp_path / "map", PLAIN, ALONE)
    assert [row.state for row in result.rows] == ["done", "done"]
    assert sum(len(route.recordings) for route in result.routes) == 2


def test_the_calibration_of_another_camera_gives_no_metres_and_says_so(surveyed):
    def change(topic, message, time):
        if topic == "/camera_info":
            message.width, message.height = 1000, 1000
        yield topic, message, time

    row, result = surveyed(change)
    assert not result.routes
    assert "no metres" in words_of(row)


def test_an_altitude_of_nought_gives_no_metres_there_and_says_so(surveyed):
    def change(topic, message, time):
        if topic == "/altitude":
            message.range = 0.0
        yield topic, message, time

    row, result = surveyed(change)
    assert not result.routes
    assert "no metres" in words_of(row) and "altitude" in words_of(row)


def test_an_altitude_that_fails_for_a_while_costs_only_that_while(surveyed):
    def change(topic, message, time):
        if topic == "/altitude" and 4 <= message.header.stamp.sec < 6:
            message.range = 0.0
        yield topic, message, time

    row, result = surveyed(change)
    assert result.routes
    assert "no metres in" in words_of(row)


def test_clocks_of_camera_and_navigation_far_apart_are_said(surveyed):
    def change(topic, message, time):
        if topic in ("/odometry", "/imu", "/fix"):
            shift(message, 1000)
        yield topic, message, time

    row, result = surveyed(change)
    assert not result.routes
    assert "clocks" in words_of(row)


def test_a_clock_that_jumps_back_is_said_and_the_rest_is_tracked(surveyed):
    def change(topic, message, time):
        if hasattr(message, "header") and message.header.stamp.sec >= 6:
            shift(message, -3)
        yield topic, message, time

    row, _ = surveyed(change)
    assert row.state == "done" and row.tracked
    assert "jump" in words_of(row)


def test_odometry_that_begins_anew_is_an_event_and_the_route_goes_on(surveyed):
    def change(topic, message, time):
        if topic == "/odometry" and message.header.stamp.sec >= 5:
            message.pose.pose.position.x -= 100.0
            message.pose.pose.position.y += 40.0
        yield topic, message, time

    row, result = surveyed(change)
    (route,) = result.routes
    assert [each for each in route.events if each.kind is EventKind.NAVIGATION]
    assert route.along[-1] == pytest.approx(4.0, abs=1.5)
    assert np.hypot(*np.diff(route.places, axis=0).T).max() < 1.0
    assert "restarted" in words_of(row)


def test_without_navigation_there_are_times_of_found_and_lost(surveyed):
    def change(topic, message, time):
        if topic not in ("/odometry", "/fix"):
            yield topic, message, time

    row, result = surveyed(change)
    assert not result.routes
    assert "pixels only" in words_of(row)


def test_a_recording_that_is_still_being_written_is_surveyed_and_done_again_later(bag, tmp_path):
    growing = tmp_path / "growing.mcap"
    whole = next(bag.glob("*.mcap")).read_bytes()
    growing.write_bytes(whole[: len(whole) * 2 // 3])
    first = run_survey([growing], tmp_path / "map", PLAIN, ALONE)
    assert "no end" in words_of(first.rows[0])
    growing.write_bytes(whole)
    again = run_survey([growing], tmp_path / "map", PLAIN, ALONE, resume=True)
    assert again.outcomes[0].state is TaskState.DONE
    assert again.rows[0].frames > first.rows[0].frames


def test_two_places_under_one_name_are_two_routes(bag, tmp_path):
    elsewhere = tmp_path / "elsewhere" / "dive"

    def change(topic, message, time):
        if topic == "/fix":
            message.latitude += 0.1
        yield topic, message, time

    elsewhere.parent.mkdir()
    rewritten(bag, elsewhere, change)
    result = run_survey([bag, elsewhere], tmp_path / "map", PLAIN, ALONE)
    assert len(result.routes) == 2
    assert [row.name for row in result.rows] == [f"{bag.parent.name}_dive", "elsewhere_dive"]


def test_names_are_as_short_as_they_may_be(tmp_path):
    paths = [tmp_path / "a/one", tmp_path / "a/two", tmp_path / "b/one"]
    assert names_of(paths) == ["a_one", "two", "b_one"]
    alike = [tmp_path / name for name in ("x/a/b", "x/c/b", "a_b")]
    assert names_of([Path(os.fsdecode(b"/dives/a\xe9"))]) == ["a\\xe9"]
    assert names_of(alike) == ["x_a_b", "x_c_b", "a_b"]
    with pytest.raises(ParameterError, match="given twice"):
        names_of([tmp_path / "a", tmp_path / "a"])


@pytest.fixture
def small_files():
    """No file can grow beyond a few kilobytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, handler)


def test_a_full_disk_is_said_and_leaves_nothing_half_written(bag, tmp_path, small_files):
    with pytest.raises(OutputError, match="cannot be written"):
        run_survey([bag], tmp_path / "map", PLAIN, ALONE)
    recordings = tmp_path / "map/recordings"
    assert not list(recordings.iterdir())
    shutil.rmtree(tmp_path / "map")
