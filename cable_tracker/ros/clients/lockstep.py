"""Tracks a recording with a tracker in another process, frame by frame in lockstep over DDS."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Final

from cable_tracker.errors import EXIT_USER_ERROR, RecordingError, RosError
from cable_tracker.node_parameter_tables import RELIABLE
from cable_tracker.offline.results import follow_all
from cable_tracker.ros.clients.recorder import ACKNOWLEDGED, RecordedFrame, Recorder, spin_until
from cable_tracker.ros.process.child_process import START_TIMEOUT, NodeProcess
from cable_tracker.ros.process.environment import use_local_environment
from cable_tracker.ros.process.node_group import NodeGroup
from cable_tracker.ros.process.ros_context import client_node
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.bag_writer import MessageSink
from cable_tracker.sequences.bags.instruments import InstrumentChoice
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.node_topics import TrackerTopics
from cable_tracker.sequences.source_base import ChosenRecording
from cable_tracker.stamps import USUAL_RATE
from cable_tracker.tracking.parameter_table import ParameterValue

FRAME_TIMEOUT = 300.0
"""Longest time for an answer, also the first, before which the replay starts [s]."""

END_TIMEOUT = 120.0
"""Longest time that the replay takes to end after its last frame [s]."""

PATIENT: Final[Mapping[str, ParameterValue]] = {"answer_timeout": 3600.0}
"""Parameters of a watched node that awaits answers: only the one that watches it gives up."""

READY_SOON: Final[Mapping[str, ParameterValue]] = {"diagnostics_period": 0.1}
"""Parameters of a tracker whose diagnostics are waited for: they tell when it is ready."""

EVERY_FRAME: Final[Mapping[str, ParameterValue]] = {"image_reliability": RELIABLE}
"""Parameters of a tracker that answers every frame that is sent."""

EVERY_MEASUREMENT: Final[Mapping[str, ParameterValue]] = {
    "instrument_reliability": RELIABLE,
    "instrument_wait": 60.0,
}
"""Parameters of a tracker whose frames wait for the measurements made before them.

A replay has sent them before the frame, so that they always come.
"""

DRIVEN: Final[Mapping[str, ParameterValue]] = {
    **EVERY_FRAME,
    **EVERY_MEASUREMENT,
    "input_timeout": 3600.0,
}
"""Parameters of a tracker in a closed loop in lockstep: frames come when others are ready."""


def replay_parameters(
    recording: ChosenRecording,
    instruments: InstrumentChoice,
    vehicle: Path | None,
    *,
    has_instruments: bool,
) -> dict[str, ParameterValue]:
    """Return the parameters of the replay node that name a recording.

    Parameters
    ----------
    recording : ChosenRecording
        The recording.
    instruments : InstrumentChoice
        Topics that the user has chosen.
    vehicle : Path or None
        The user's `vehicle.yaml`.
    has_instruments : bool
        Whether the node sends what the instruments said.

    Raises
    ------
    RosError
        A path is not UTF-8.
    """
    for path in filter(None, (recording.path, recording.truth, vehicle)):
        _need_utf8(path.resolve())
    return {
        "source": str(recording.path.resolve()),
        "topic": recording.topic or "",
        "frame_rate": recording.rate or USUAL_RATE,
        "truth": str(recording.truth.resolve()) if recording.truth else "",
        "skip_bad_frames": recording.skip_bad_frames,
        "allow_outside": recording.allow_outside,
        "instruments": has_instruments,
        "vehicle": str(vehicle.resolve()) if vehicle else "",
        **{f"{each.value}_topic": topic for each, topic in instruments.topics.items()},
    }


def _need_utf8(path: Path) -> None:
    """Refuse a path that no parameter of a node can hold: ROS would blame the file of them all."""
    try:
        str(path).encode()
    except UnicodeEncodeError as error:
        raise RosError(
            f"{path}: a path that is not UTF-8 cannot be told to a node; rename the file or folder,"
            " for example with convmv, or leave out --ros"
        ) from error


def tracker_parameters(*, compressed: bool) -> dict[str, ParameterValue]:
    """Return the parameters of any tracker in lockstep, by whether its pictures are compressed."""
    return {
        **EVERY_FRAME,
        **READY_SOON,
        "image_transport": "compressed" if compressed else "raw",
        # The same estimates as without ROS, whatever the recording shows.
        "frozen_timeout": 0.0,
    }


def track_in_lockstep(
    frames: Iterable[Frame],
    topics: TrackerTopics,
    parameters: Mapping[str, ParameterValue],
    replay: Mapping[str, ParameterValue],
    take: Callable[[Frame, RecordedFrame], Message],
) -> RecordingError | None:
    """Let a tracker's process answer all frames of a recording, which a replay's process sends.

    Both run under a namespace of this process, so that they meet no other node. The replay sends a
    frame only when everything about the frame before has been taken.

    Parameters
    ----------
    frames : iterable of Frame
        Those of the same recording, which is open in this process, too.
    topics : TrackerTopics
        Topics of the tracker, which tell its name.
    parameters : mapping
        Parameters of the tracker: `tracker_parameters`, those of its method, and where it starts.
    replay : mapping
        Parameters of the replay node that name the recording, see `replay_parameters`.
    take : callable
        Called with each frame and what the tracker published about it; returns its state.

    Returns
    -------
    RecordingError or None
        Where the recording broke off.

    Raises
    ------
    RosError
        The processes do not find each other, or one of them has died.
    """
    use_local_environment()
    namespace = f"/cable_tracker_{os.getpid()}"
    with (
        client_node(lambda context: Recorder(context, namespace, topics)) as (recorder, executor),
        NodeGroup(namespace) as group,
    ):
        group.start(topics.node, parameters)
        spin_until(
            executor,
            recorder.is_subscribed,
            START_TIMEOUT,
            group.what_has_died,
            recorder.is_warming,
        )
        player = group.start(
            "replay",
            {**replay, **PATIENT, "lockstep": True},
            {node_topics.STATE.name: ACKNOWLEDGED},
            may_end=True,
        )

        def record(frame: Frame) -> None:
            # The replay may have sent its last frame and ended while the answer is still awaited.
            recorded = spin_until(executor, recorder.take, FRAME_TIMEOUT, group.what_has_died)
            recorder.acknowledge(take(frame, recorded))

        damage = follow_all(frames, record)
        _finish(player, damage)
    return damage


def write_messages(bag: MessageSink, frame: Frame, recorded: RecordedFrame) -> None:
    """Write what was published about a frame, and the diagnostics that came meanwhile."""
    for topic, data in recorded.messages.items():
        bag.write_serialised(topic.global_name, topic.type_name, data, frame.bag_time)
    for data in recorded.diagnostics:
        topic = node_topics.DIAGNOSTICS
        bag.write_serialised(topic.global_name, topic.type_name, data, frame.bag_time)


def _finish(replay: NodeProcess, damage: RecordingError | None) -> None:
    """Wait for the replay to end by itself, and see that it ended as expected."""
    code = replay.wait(END_TIMEOUT)
    if code is None:
        raise RosError(f"the replay has not ended for {END_TIMEOUT:g} s after all frames")
    if code != (0 if damage is None else EXIT_USER_ERROR):
        last = replay.last_line()
        raise RosError(f"the replay ended with exit code {code} after all frames: {last}")
