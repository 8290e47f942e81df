"""A tracker and a replay in processes of their own give what the core gives."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import Reader

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.initial_state_text import RANDOM, format_initial_state
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.detection.line_pairs import DEFAULT_LIMITS, pair_limits
from cable_tracker.errors import RecordingError
from cable_tracker.metric.recorded_instruments import recorded_vehicle
from cable_tracker.offline.cable_folder import CableFolder
from cable_tracker.offline.results import BAG, ESTIMATES, follow_all
from cable_tracker.offline.track_cable import (
    TRUTH,
    given_state_for,
    track_frame,
)
from cable_tracker.ros.clients.lockstep import tracker_parameters
from cable_tracker.ros.clients.track_cable import track_cable_over_ros
from cable_tracker.sequences.bags.bag_writer import BagWriter
from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages, typestore
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_image
from cable_tracker.sequences.source import open_source
from cable_tracker.sequences.tables.estimates import EstimateRow, write_estimates
from cable_tracker.trackers import make_tracker

PARAMETERS = TrackerParameters(seed=4, particle_count=200)
OVERLAY = "/tracker/overlay/compressed"
FOOTAGE_FRAMES = 10


class TableAndBag(CableFolder):
    """Results as always, but for the pictures: those take their time, and are tested elsewhere."""

    def _add_picture(self, frame: Frame, *_: Any) -> None:
        self._video.add(np.zeros((32, 32, 3), np.uint8), frame.stamp)

    def _write_summaries(self) -> None:
        write_estimates(self._content / ESTIMATES, self.rows)


@dataclass
class Outcome:
    """What is left of a tracked recording."""

    rows: list[EstimateRow]
    truths: dict[int, CableState]
    bag: Path
    damage: RecordingError | None


@pytest.fixture
def track(tmp_path: Path) -> Callable[..., Outcome]:
    """Track a recording with the nodes or without."""

    def tracked(
        path: Path, over_ros: bool, words: str = RANDOM, given: GivenState | None = None
    ) -> Outcome:
        folder = tmp_path / ("ros" if over_ros else "core")
        with ExitStack() as stack:
            source = stack.enter_context(open_source(path))
            results = stack.enter_context(TableAndBag(folder))

            if over_ros:
                vehicle, replay = recorded_vehicle(source), {"source": str(path)}
                own = {
                    **tracker_parameters(compressed=source.compressed),
                    **PARAMETERS.as_mapping(),
                    "initial_state": words,
                }
                damage = track_cable_over_ros(source.frames(), own, replay, results, vehicle)
            else:
                tracker = make_tracker(PARAMETERS)
                if given is not None:
                    tracker.initialise(given)
                damage = follow_all(
                    source.frames(), lambda frame: track_frame(frame, tracker, results, None)
                )
        return Outcome(results.rows, results.truths, folder / BAG, damage)

    return tracked


def without_times(rows: list[EstimateRow]) -> list[EstimateRow]:
    """Rows without what differs."""
    return [replace(row, ms=None) for row in rows]


def messages_of(bag: Path, topic: str) -> list[tuple[int, bytes]]:
    """Times and bytes of the messages on a topic, the gaps of the alignment filled with zeros."""
    with Reader(bag) as reader:
        connections = [c for c in reader.connections if c.topic == topic]
        return [
            (time, rewritten(data, connection.msgtype))
            for connection, time, data in reader.messages(connections)
        ]


def rewritten(data: bytes, msgtype: str) -> bytes:
    store = typestore()
    return bytes(store.serialize_cdr(store.deserialize_cdr(data, msgtype), msgtype))


def assert_same(ros: Outcome, core: Outcome, frames: int) -> None:
    assert len(core.rows) == frames
    assert without_times(ros.rows) == without_times(core.rows)
    assert ros.truths == core.truths
    # Nothing was recorded, or said, that metres could be expected from.
    assert all(row.metres is None and not row.no_metres for row in core.rows)
    assert all(row.ms is not None and row.ms > 0.0 for row in ros.rows if row.n_eff)


def test_a_simulated_dive_gives_the_same_table_and_the_same_messages(
    make_dive: Callable[..., Path], track: Callable[..., Outcome]
) -> None:
    path = make_dive(8)
    with open_source(path) as source:
        given = given_state_for(source, TRUTH, DEFAULT_LIMITS)
    assert given is not None
    words = format_initial_state(given.state)
    ros, core = track(path, True, words), track(path, False, given=given)
    assert_same(ros, core, 8)
    assert any(row.state is not None for row in core.rows)
    for topic in ("/state", "/centreline", "/particles", "/markers", "/ground_truth", OVERLAY):
        recorded = messages_of(ros.bag, topic)
        assert recorded
        assert recorded == messages_of(core.bag, topic)
    assert messages_of(ros.bag, "/diagnostics")


@pytest.mark.slow
def test_from_a_detection_a_dive_gives_the_same_table(
    make_dive: Callable[..., Path], track: Callable[..., Outcome]
) -> None:
    path = make_dive(6)
    with open_source(path) as source:
        found = given_state_for(source, "hough", pair_limits(PARAMETERS))
    assert found is not None and found.is_guess
    ros, core = track(path, True, "hough"), track(path, False, given=found)
    assert_same(ros, core, 6)


@pytest.mark.slow
def test_from_random_a_recording_of_jpegs_gives_the_same_table(
    make_dive: Callable[..., Path], track: Callable[..., Outcome]
) -> None:
    path = make_dive(10, storage="sqlite3", jpeg=True)
    assert_same(track(path, True), track(path, False), 10)


def test_large_frames_in_colour_arrive_whole(
    colour_bag: Callable[..., Path], track: Callable[..., Outcome]
) -> None:
    path = colour_bag(3, (1280, 720))
    assert_same(track(path, True), track(path, False), 3)


@pytest.mark.slow
def test_real_footage_gives_the_same_table(
    tmp_path: Path, track: Callable[..., Outcome], real_footage: Callable[..., Path]
) -> None:
    folder = real_footage("strip", "strip.mp4", "strip.txt")
    with open_source(folder / "strip.mp4", truth=folder / "strip.txt") as source:
        frames = list(islice(source.frames(), FOOTAGE_FRAMES))
    labelled = [frame.truth for frame in frames if frame.truth is not None]
    write_bag(tmp_path / "strip", frames)
    words = format_initial_state(labelled[0])
    given = GivenState.around(labelled[0])
    ros, core = (track(tmp_path / "strip", over_ros, words, given) for over_ros in (True, False))
    assert_same(ros, core, FOOTAGE_FRAMES)
    assert any(row.state is not None for row in core.rows)


@pytest.mark.slow
def test_frames_before_the_damage_are_tracked(
    damaged_dive: Path, track: Callable[..., Outcome]
) -> None:
    ros, core = track(damaged_dive, True), track(damaged_dive, False)
    assert_same(ros, core, len(core.rows))
    assert 0 < len(core.rows) < 12
    assert ros.damage is not None and str(ros.damage) == str(core.damage)


@pytest.mark.slow
def test_a_recording_whose_times_jump_back_is_tracked_to_its_end(
    tmp_path: Path,
    dive_frames: Callable[..., Iterator[Frame]],
    track: Callable[..., Outcome],
) -> None:
    factory = RosbagsMessages()
    with BagWriter(tmp_path / "jump") as bag:
        for frame, milliseconds in zip(dive_frames(4), [2_000, 2_040, 500, 540], strict=True):
            header = make_header(factory, milliseconds * 1_000_000, "camera")
            message = make_image(factory, frame.image, header)  # type: ignore[arg-type]
            bag.write("/image", "sensor_msgs/msg/Image", message, 10**9 + frame.index)
    path = tmp_path / "jump"
    assert_same(track(path, True), track(path, False), 4)
