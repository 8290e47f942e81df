import errno
import json
from pathlib import Path

import numpy as np
import pytest

from cable_tracker.errors import OutputError
from cable_tracker.metric.recorded.recorded_cable import recorded_vehicle
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.bags.storage_files import TRUTH_FILE
from cable_tracker.sequences.source import open_source
from cable_tracker.simulation.instruments.dive_ticks import dive_ticks
from cable_tracker.simulation.instruments.instrument_writer import (
    ORIGIN,
    to_east_north,
    write_ticks,
)
from cable_tracker.simulation.instruments.survey_bag import write_survey_bag
from cable_tracker.simulation.instruments.survey_dive import SurveyDiveSettings
from cable_tracker.simulation.scenarios.scenario_dive import (
    SimulationSettings,
    simulate,
    simulated_dive,
)


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
