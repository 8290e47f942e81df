from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from cable_tracker.errors import OutputError
from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.source import open_source
from cable_tracker.simulation.instruments.instrument_writer import (
    ORIGIN,
    fix_at,
    vehicle_text,
    write_ticks,
)
from cable_tracker.simulation.instruments.survey_dive import TICKS, SurveyDive, SurveyDiveSettings


def test_the_origin_of_the_world_lies_where_it_is_said_to():
    fix = fix_at(LocalFrame(*ORIGIN), np.zeros(2), 0.0)
    assert (fix.latitude, fix.longitude) == pytest.approx(ORIGIN, abs=1e-9)
    assert fix.height == pytest.approx(0.0, abs=1e-6)


def test_what_is_written_of_the_vehicle_goes_with_its_bag(tmp_path):
    text = vehicle_text(0.05)
    for vehicle in (text.encode(), None):
        with BagWriter(tmp_path / "bag", overwrite=True, vehicle=vehicle):
            pass
    assert not (tmp_path / "bag" / "vehicle.yaml").exists()
    with BagWriter(tmp_path / "bag", overwrite=True, vehicle=text.encode()):
        pass
    (tmp_path / "bag" / "vehicle.yaml").write_text(text + "camera_x: 0.2\n")
    with (
        pytest.raises(OutputError, match=r"vehicle\.yaml: .*move it elsewhere"),
        BagWriter(tmp_path / "bag", overwrite=True, vehicle=text.encode()),
    ):
        pass


def test_the_height_of_the_cable_is_written_with_sensible_digits():
    assert "\ncable_height: 0.056\n" in vehicle_text(0.055999999999999994)


def test_only_a_cable_that_can_be_seen_has_a_truth_in_the_bag(tmp_path):
    dive = SurveyDive(SurveyDiveSettings(length=4.0, image_size=(64, 48), rate=5.0))
    ticks = list(islice(dive.ticks(), 2 * TICKS))
    ticks[TICKS] = replace(ticks[TICKS], frame=replace(ticks[TICKS].frame, truth=None))
    write_ticks(tmp_path / "dive", ticks, dive.camera, dive.cable_height)
    with open_source(tmp_path / "dive") as source:
        assert [frame.truth is None for frame in source.frames()] == [False, True]
        assert source.storage.topics["/ground_truth"].count == 1
