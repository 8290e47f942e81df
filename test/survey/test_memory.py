"""Memory does not grow with a dive, but for what a route takes; arrays lie on the disk."""

import tracemalloc
from dataclasses import replace
from functools import cache

import numpy as np
import pyarrow.parquet as pq
import pytest
from survey_dives import DISK, Plan, make_dive

from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.survey.forward_pass import ForwardDive
from cable_tracker.survey.frame_table import ROW, FrameTable, Samples
from cable_tracker.survey.memory_mapped import Disk
from cable_tracker.survey.outputs.frames import write_frames
from cable_tracker.survey.recording import SurveySettings, analyse
from cable_tracker.survey.routes.dive_route import DiveRoute

WHOLE = 10**6
"""A block that holds all of a dive."""

DATUM = (54.0, 7.0)
SMOOTHED = ("along", "states", "covariances", "weights", "piece")

MOST_BYTES = 120
"""Of memory for each picture while a dive is smoothed and written, of which a route takes a half:
these pictures are 5 cm apart. All in memory it would be more than 700."""


@cache
def dive_to_read(plan: Plan) -> ForwardDive:
    """A dive of which only copies are worked on."""
    return make_dive(plan)


def hard_dive(disk: Disk, length: float = 35.0) -> ForwardDive:
    """Two ways along the cable, the second with an odometry that began anew; with fixes."""
    dive, frame = ForwardDive(make_dive(Plan(length=1.0)).name, disk), LocalFrame(*DATUM)
    plan = Plan(length=length, hidden=((10.0, 14.0),), rope=((30.0, 33.0),), wrong=((20.0, 21.0),))
    for number, turn in enumerate((0.0, 3.0)):
        other = dive_to_read(replace(plan, seed=number))
        later = number * 10**12
        for row in other.table.rows:
            own = dive.table.append()
            for name in ROW.names:
                own[name] = row[name]
            own["stamp"] += later
        cos, sin = np.cos(turn), np.sin(turn)
        for count, (stamp, (x, y, yaw, speed)) in enumerate(
            zip(*other.poses.arrays(), strict=True)
        ):
            pose = [x * cos - y * sin, x * sin + y * cos, yaw + turn, speed]
            dive.poses.add(int(stamp) + later, pose)
            if count % 10 == 0:
                (place,) = frame.to_degrees(np.array([[x, y + 30.0 * (count == 200)]]))
                dive.fixes.add(int(stamp) + later, [*place, 0.25, 0.25])
    return dive


def written(dive: ForwardDive, path, datum=None):
    surveyed, course = analyse(dive, SurveySettings(datum=datum))
    write_frames(path, "dive", dive, course)
    return surveyed, course


@pytest.mark.parametrize("datum", [None, DATUM])
@pytest.mark.parametrize(
    "block", [7, *(pytest.param(size, marks=pytest.mark.slow) for size in (1, 300))]
)
def test_block_by_block_is_bit_for_bit_as_all_at_once(tmp_path, block, datum):
    length = 12.0 if block == 1 or datum is None else 35.0
    dives = [hard_dive(Disk(block=size), length) for size in (block, WHOLE)]
    paths = [tmp_path / "blocks.parquet", tmp_path / "whole.parquet"]
    (surveyed, course), (other, others_course) = (
        written(dive, path, datum) for dive, path in zip(dives, paths, strict=True)
    )
    assert surveyed.on_earth is (datum is not None)
    assert surveyed.notes == other.notes
    for name in SMOOTHED:
        found, expected = (getattr(each.cable, name) for each in (course, others_course))
        assert found.tobytes() == expected.tobytes(), name
    assert len(surveyed.routes) == len(other.routes) > 0
    for placed, expected in zip(surveyed.routes, other.routes, strict=True):
        assert placed.events == expected.events
        for name in DiveRoute.__dataclass_fields__:
            if name not in {"profile", "start"}:
                columns = (getattr(each.route, name) for each in (placed, expected))
                assert len({column.tobytes() for column in columns}) == 1, name
        seen = (each.route.profile.seen.tobytes() for each in (placed, expected))
        assert len(set(seen)) == 1
    tables = [pq.read_table(path).to_pylist() for path in paths]
    assert repr(tables[0]) == repr(tables[1])


def peak_of(dive, path) -> int:
    tracemalloc.start()
    written(dive, path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


@pytest.mark.slow
def test_a_longer_dive_takes_little_more_memory(tmp_path):
    plans = (Plan(length=length) for length in (230.0, 230.0, 430.0))
    dives = [make_dive(plan, disk=Disk(block=100)) for plan in plans]
    # What is compiled and imported at first stays.
    _, short, long = (peak_of(dive, tmp_path / "frames.parquet") for dive in dives)
    assert long - short < MOST_BYTES * (len(dives[2].table) - len(dives[1].table))


def test_a_dive_that_is_tracked_longer_keeps_no_more_in_memory():
    def kept(count: int) -> int:
        tracemalloc.start()
        table, poses = FrameTable(Disk(block=50)), Samples(4, Disk(block=50))
        for number in range(count):
            table.append()["frame"] = number
            poses.add(number, [0.0] * 4)
        size = tracemalloc.get_traced_memory()[0]
        tracemalloc.stop()
        assert len(table) == len(poses) == count
        return size

    def least_kept(count: int) -> int:
        # What other threads, and what happens once, need meanwhile does not count.
        return min(kept(count) for _ in range(3))

    assert least_kept(5000) - least_kept(500) < 4500


def test_a_row_is_small():
    assert ROW.itemsize <= 144


def test_rows_are_kept_over_many_blocks():
    table = FrameTable(DISK)
    for number in range(10_000):
        table.append()["frame"] = number
        if number in {17, 5000}:
            assert len(table.rows) == number + 1
    assert len(table) == 10_000
    assert (table.rows["frame"] == range(10_000)).all()
