import errno
import json
import math
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from cable_tracker.errors import OutputError, ParameterError
from cable_tracker.metric.recorded_instruments import recorded_vehicle
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.bags.storage_files import TRUTH_FILE
from cable_tracker.sequences.source import open_source
from cable_tracker.simulation.cable_scene import cable_of_seed, cable_points
from cable_tracker.simulation.instruments.dive_ticks import dive_ticks
from cable_tracker.simulation.instruments.instrument_writer import (
    ORIGIN,
    to_east_north,
    write_ticks,
)
from cable_tracker.simulation.instruments.survey_dive import (
    TICKS,
    SurveyDive,
    SurveyDiveSettings,
    usual_survey,
    write_survey_bag,
)
from cable_tracker.simulation.scenario_dive import (
    SimulationSettings,
    simulate,
    simulated_dive,
)

SMALL = SurveyDiveSettings(seed=3, length=4.0, image_size=(64, 48), rate=5.0)


def test_every_manieth_tick_has_a_picture_and_an_altitude():
    ticks = list(islice(SurveyDive(SMALL).ticks(), 3 * TICKS))
    assert [tick.frame is not None for tick in ticks] == ([True] + [False] * (TICKS - 1)) * 3
    assert all((tick.altitude is None) == (tick.frame is None) for tick in ticks)


def test_the_vehicle_stays_over_the_cable_to_its_end():
    ticks = list(SurveyDive(SMALL).ticks())
    tube = cable_of_seed(SMALL.cable_seed)
    course = cable_points(tube, np.arange(-3.0, 8.0, 0.05))[0][:, :2]
    for tick in ticks:
        away = np.hypot(*(course - tick.state.position[:2]).T).min()
        assert away < 0.6
    assert ticks[-1].state.position[0] > SMALL.length - 0.5


def test_the_rates_of_the_truth_are_the_slope_of_its_places():
    dive = SurveyDive(replace(SMALL, length=1.5, rate=25.0))
    truths = [tick.frame.truth for tick in dive.ticks() if tick.frame is not None]
    states = np.array([truth.to_array() for truth in truths])
    slopes = (states[2:, :4] - states[:-2, :4]) * 12.5
    # The vehicle is pushed in between, too.
    spread = slopes.std(axis=0)
    assert (np.abs(states[1:-1, 4:] - slopes).max(axis=0) < 0.3 * spread).all()


def test_dives_over_one_cable_differ_in_all_but_the_cable():
    first, second = (next(SurveyDive(replace(SMALL, seed=seed)).ticks()) for seed in (1, 2))
    assert not np.array_equal(first.imu.angles, second.imu.angles)
    np.testing.assert_array_equal(first.state.position, second.state.position)


def test_the_same_seed_gives_the_same_dive():
    first, second = (list(islice(SurveyDive(SMALL).ticks(), 6)) for _ in range(2))
    for a, b in zip(first, second, strict=True):
        np.testing.assert_array_equal(a.odometry.position, b.odometry.position)


def test_a_usual_survey_has_a_burial_in_50_m_and_a_crossing_in_100_m():
    settings = usual_survey(200.0, seed=5)
    assert len(settings.buried) == 4 and len(settings.crossings) == 2
    assert all(0 < each.end - each.start < 10 for each in settings.buried)
    assert usual_survey(200.0, seed=6).buried == settings.buried


@pytest.mark.parametrize(
    "wrong",
    [
        {"length": 0.0},
        {"rate": 0.0},
        {"speed": 0.0},
        {"altitude": 0.0},
        {"seed": -1},
    ],
)
def test_settings_that_cannot_be_are_refused(wrong):
    with pytest.raises(ParameterError):
        SurveyDiveSettings(**wrong)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [((math.nan, 0), "length"), ((math.inf, 0), "length"), ((200.0, 0, -1), "cable_seed is -1")],
)
def test_a_usual_survey_that_cannot_be_is_refused_in_words(wrong, words):
    with pytest.raises(ParameterError, match=words):
        usual_survey(*wrong)


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("survey") / "dive"
    write_survey_bag(path, SurveyDiveSettings(length=1.5, image_size=(64, 48), rate=5.0))
    return path


def test_the_bag_holds_all_instruments(bag):
    with open_source(bag) as recording:
        vehicle = recorded_vehicle(recording)
    assert set(vehicle.source.found.topics) == set(Instrument)
    assert not vehicle.notes


def test_mounting_and_heights_are_known_from_the_bag_alone(bag):
    with open_source(bag) as recording:
        vehicle = recorded_vehicle(recording).vehicle.parameters
    assert vehicle.camera_pitch == pytest.approx(70.0)
    assert vehicle.altitude_is_vertical is True
    assert vehicle.cable_height > 0.0


def test_the_truth_of_the_course_lies_beside_it(bag):
    truth = json.loads((bag / TRUTH_FILE).read_text())
    world, east_north = np.array(truth["world"]), np.array(truth["east_north"])
    np.testing.assert_allclose(to_east_north(world), east_north)
    assert truth["origin"] == list(ORIGIN)


def _write_survey(path: Path) -> None:
    write_survey_bag(path, SurveyDiveSettings(length=1.0, image_size=(64, 48), rate=1.0))


def _write_instrumented(path: Path) -> None:
    settings = SimulationSettings(frame_count=1, image_size=(64, 48))
    dive = simulated_dive(settings)
    ticks = dive_ticks(simulate(settings), dive, 25.0, 0)
    write_ticks(path, ticks, dive.camera, dive.tube.height)


@pytest.mark.parametrize("write", [_write_survey, _write_instrumented])
def test_a_disk_that_is_full_after_the_bag_is_an_output_error(write, tmp_path, monkeypatch):
    original = Path.open

    def full(path, *args, **kwargs):
        if "vehicle" in path.name:
            raise OSError(errno.ENOSPC, "No space left on device")
        return original(path, *args, **kwargs)

    monkeypatch.setattr(Path, "open", full)
    with pytest.raises(OutputError):
        write(tmp_path / "dive")
