"""A target followed through a recording, with the vehicle's instruments."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from chase_bag import write_chase_bag

from cable_tracker.metric.recorded_instruments import recorded_vehicle
from cable_tracker.metric.targets.recorded_target import recorded_target
from cable_tracker.offline.results import ESTIMATES, METRES, WantedResults, follow_all
from cable_tracker.offline.target_folder import TargetFolder
from cable_tracker.offline.track_target import follow_frame
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.source import open_source
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.tracker import TargetTracker

TABLES_ALONE = WantedResults(video=False, bag=False, pictures=False)


@pytest.fixture
def refused_in_the_middle(tmp_path):
    """Follow a target through a bag whose second frame is too small; return the folder."""
    ((box, _), *_) = write_chase_bag(tmp_path / "dive", 3)
    tracker = TargetTracker()
    tracker.initialise(TargetStart.from_box(*box))
    with open_source(tmp_path / "dive") as source:
        frames = list(source.frames())
        tiny = raw_from_array(np.zeros((2, 2, 3), np.uint8), "bgr8")
        frames[1] = replace(frames[1], image=tiny)
        with (
            recorded_target(recorded_vehicle(source)) as instruments,
            TargetFolder(tmp_path / "out", wanted=TABLES_ALONE) as results,
        ):
            follow_all(frames, lambda frame: follow_frame(frame, tracker, results, instruments))
    return results.path


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_each_frame_has_a_row_in_metres_also_one_that_was_refused(refused_in_the_middle):
    metres = rows_of(refused_in_the_middle / METRES)
    estimates = rows_of(refused_in_the_middle / ESTIMATES)
    assert [row["status"] for row in estimates] == ["TRACKING", "REFUSED", "TRACKING"]
    assert [row["frame"] for row in metres] == ["0", "1", "2"]
    assert [row["stamp"] for row in metres] == [row["stamp"] for row in estimates]
    assert [bool(row["bearing_x"]) for row in metres] == [True, False, True]
    assert metres[1]["why_not"].startswith("the frame was refused: 2x2 px is too small")
