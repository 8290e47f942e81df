"""Track a whole recording with both nodes in processes of their own, over DDS, in lockstep."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from rclpy.executors import SingleThreadedExecutor

from cable_tracker.cable.model.initial_state_text import RANDOM, format_initial_state
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import ParameterValue, TrackerParameters
from cable_tracker.errors import RecordingError, RosError
from cable_tracker.evaluation.tracking.result_folder import ResultFolder
from cable_tracker.metric.messages import METRES_KEYS, NO_METRES_KEY
from cable_tracker.metric.recorded import RecordedVehicle
from cable_tracker.ros.clients.recorder import ACKNOWLEDGED, RecordedFrame, Recorder, spin_until
from cable_tracker.ros.process.child_process import START_TIMEOUT, NodeProcess
from cable_tracker.ros.process.client_node import client_node
from cable_tracker.ros.process.environment import local_environment, use_local_environment
from cable_tracker.sequences import output_topics
from cable_tracker.sequences.bag_writer import MessageSink
from cable_tracker.sequences.convert import write_truth
from cable_tracker.sequences.estimates import EstimateRow, RowMetres
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages import (
    Message,
    read_cloud,
    read_sigma,
    read_state,
)
from cable_tracker.sequences.source import Source
from cable_tracker.tracking.parameter_files import write_node_parameters

FRAME_TIMEOUT = 60.0
LONGEST_WAIT = 30.0
"""For the instruments of a frame [s]; they have been sent, so that it is not waited for in vain."""

END_TIMEOUT = 10.0


@dataclass(frozen=True, slots=True)
class RecordingRequest:
    """Which recording to track, and how, in words that the nodes understand.

    Attributes
    ----------
    source : dict
        Parameters of the replay node that name the recording.
    parameters : TrackerParameters
        Parameters of the filter.
    initial_state : CableState or None
        Where to start; None for random.
    vehicle : RecordedVehicle or None
        With its instruments; None: everything stays in pixels.
    """

    source: dict[str, ParameterValue]
    parameters: TrackerParameters
    initial_state: CableState | None
    vehicle: RecordedVehicle | None = None


def track_recording_over_ros(
    source: Source,
    request: RecordingRequest,
    results: ResultFolder,
    advance: Callable[[], None] = lambda: None,
) -> RecordingError | None:
    """Track all frames of a source with a `tracker` and a `replay` process.

    Both run under a namespace of this process, so that they meet no other node. The replay sends a
    frame only when everything about the frame before has been recorded.

    Parameters
    ----------
    source : Source
        The same recording, open in this process, for the pictures and the ground truth.
    request : RecordingRequest
        What the nodes are told.
    results : ResultFolder
        Where the results go.
    advance : callable
        Called after each frame.

    Returns
    -------
    RecordingError or None
        Where the recording broke off; the frames before that are in the results.

    Raises
    ------
    RosError
        The processes do not find each other, or one of them has died.
    """
    use_local_environment()
    namespace = f"/cable_tracker_{os.getpid()}"
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        recorder, executor = stack.enter_context(
            client_node(lambda context: Recorder(context, namespace))
        )
        tracker = stack.enter_context(
            start_node("tracker", namespace, folder, _tracker_parameters(source, request), [])
        )
        run = _CableRun(executor, recorder, tracker, results)
        run.wait_for_tracker()
        run.replay = stack.enter_context(
            start_node(
                "replay",
                namespace,
                folder,
                {
                    **request.source,
                    "lockstep": True,
                    "instruments": bool(request.vehicle and request.vehicle.has_instruments),
                },
                ["-r", f"state:={ACKNOWLEDGED}"],
            )
        )
        damage = run.record_all(source, advance)
        run.finish(damage)
    return damage


def _tracker_parameters(source: Source, request: RecordingRequest) -> dict[str, ParameterValue]:
    state = request.initial_state
    return {
        **request.parameters.as_mapping(),
        "image_transport": "compressed" if source.compressed else "raw",
        "image_reliability": "reliable",
        "initial_state": RANDOM if state is None else format_initial_state(state),
        "diagnostics_period": 0.1,
        # The same estimates as without ROS, whatever the recording shows.
        "frozen_timeout": 0.0,
        **_vehicle_parameters(request.vehicle),
    }


def _vehicle_parameters(vehicle: RecordedVehicle | None) -> dict[str, ParameterValue]:
    if vehicle is None or not vehicle.has_instruments:
        return {}
    return {
        **cast(dict[str, ParameterValue], vehicle.vehicle.values),
        "instrument_reliability": "reliable",
        # A frame waits until all has come that the replay has sent before it.
        "instrument_wait": LONGEST_WAIT,
    }


def start_node(
    name: str,
    namespace: str,
    folder: Path,
    parameters: dict[str, ParameterValue],
    arguments: list[str],
) -> NodeProcess:
    """Start a node in a process of its own.

    Parameters
    ----------
    name : str
        Of its executable.
    namespace : str
        In which it lives.
    folder : Path
        For a file with its parameters.
    parameters : dict
        Those.
    arguments : list of str
        Further ones, after `--ros-args`.
    """
    file = folder / f"{name}.yaml"
    write_node_parameters(file, parameters)
    return NodeProcess(
        name,
        [
            "--params-file", str(file),
            "-r", f"__ns:={namespace}",
            "-r", "/diagnostics:=diagnostics",
            *arguments,
        ],
        local_environment(),
    )  # fmt: skip


class LockstepRun:
    """One recording on its way through the nodes.

    Parameters
    ----------
    executor : SingleThreadedExecutor
        Runs the recorder.
    recorder : Recorder
        Hears what the tracker says.
    tracker : NodeProcess
        The tracker's process.

    Attributes
    ----------
    replay : NodeProcess or None
        The replay's process, once it is started.
    """

    def __init__(
        self, executor: SingleThreadedExecutor, recorder: Recorder, tracker: NodeProcess
    ) -> None:
        self._executor = executor
        self._recorder = recorder
        self._tracker = tracker
        self.replay: NodeProcess | None = None

    def wait_for_tracker(self) -> None:
        """Wait until the tracker knows that everything it publishes is recorded."""
        spin_until(
            self._executor,
            self._recorder.is_subscribed,
            START_TIMEOUT,
            self._what_has_died,
            self._recorder.is_warming,
        )

    def record_all(self, source: Source, advance: Callable[[], None]) -> RecordingError | None:
        """Record every frame of the source."""
        try:
            for frame in source.frames():
                self._record(frame)
                advance()
        except RecordingError as error:
            return error
        return None

    def _record(self, frame: Frame) -> None:
        taken: list[RecordedFrame] = []

        def has_come() -> bool:
            recorded = self._recorder.take()
            if recorded is not None:
                taken.append(recorded)
            return bool(taken)

        spin_until(self._executor, has_come, FRAME_TIMEOUT, self._what_has_died)
        state = self._write(frame, taken[0])
        self._recorder.acknowledge(state)

    def _write(self, frame: Frame, recorded: RecordedFrame) -> Message:
        """Write what a frame gave, and return its state."""
        raise NotImplementedError

    def _write_messages(self, bag: MessageSink, frame: Frame, recorded: RecordedFrame) -> None:
        for topic, data in recorded.messages.items():
            bag.write_serialised(f"/{topic.name}", topic.type_name, data, frame.stamp)
        for data in self._recorder.take_diagnostics():
            topic = output_topics.DIAGNOSTICS
            bag.write_serialised(f"/{topic.name}", topic.type_name, data, frame.stamp)

    def finish(self, damage: RecordingError | None) -> None:
        """Wait for the replay to end by itself, and see that it ended as expected."""
        assert self.replay is not None
        code = self.replay.wait(END_TIMEOUT)
        expected = 0 if damage is None else 2
        if code != expected:
            words = self.replay.last_line()
            raise RosError(f"the replay ended with exit code {code} after all frames: {words}")

    def _what_has_died(self) -> str:
        if not self._tracker.running:
            return f"the tracker node has died: {self._tracker.last_line()}"
        if self.replay is None or self.replay.running:
            return ""
        # It may have sent its last frame and ended while we still wait for the answer.
        code = self.replay.wait(0.0)
        return "" if code == 0 else f"the replay node has died: {self.replay.last_line()}"


class _CableRun(LockstepRun):
    def __init__(
        self,
        executor: SingleThreadedExecutor,
        recorder: Recorder,
        tracker: NodeProcess,
        results: ResultFolder,
    ) -> None:
        super().__init__(executor, recorder, tracker)
        self._results = results

    def _write(self, frame: Frame, recorded: RecordedFrame) -> Message:
        write_truth(self._results.bag, frame)
        self._write_messages(self._results.bag, frame, recorded)
        state = recorded.read(output_topics.STATE)
        cloud = None
        if output_topics.PARTICLES in recorded.messages:
            cloud = read_cloud(recorded.read(output_topics.PARTICLES))
        self._results.add(frame, _row(frame, recorded, state), cloud)
        return state


def _row(frame: Frame, recorded: RecordedFrame, state: Message) -> EstimateRow:
    report = recorded.read(output_topics.FRAME_REPORT)
    values = {pair.key: pair.value for pair in report.status[0].values}

    def number(key: str) -> float | None:
        return float(values[key]) if values.get(key) else None

    claimed = read_state(state)
    return EstimateRow(
        frame=frame.index,
        stamp=frame.stamp,
        status=recorded.status,
        state=claimed,
        sigma=read_sigma(state) if claimed is not None else None,
        n_eff=number("n_eff"),
        presence=number("presence"),
        evidence=number("evidence"),
        hypotheses=len(values["hypotheses"].split()) if "hypotheses" in values else None,
        ms=number("ms"),
        metres=_row_metres(values),
        no_metres=values.get(NO_METRES_KEY, ""),
    )


def _row_metres(values: Mapping[str, str]) -> RowMetres | None:
    if METRES_KEYS[0] not in values:
        return None
    return RowMetres(*(float(values[key]) for key in METRES_KEYS))
