"""How long an image takes through a node in another process, over DDS on this machine."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from std_srvs.srv import Trigger

from cable_tracker.arrays import Image as Picture
from cable_tracker.benchmark.footage import FRAME_STEP, Footage
from cable_tracker.benchmark.node_timing import NodeTiming
from cable_tracker.benchmark.statistics import Percentiles
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.initial_state_text import format_initial_state
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.errors import RosError
from cable_tracker.evaluation.methods import ConfiguredFilter
from cable_tracker.ros import qos
from cable_tracker.ros.clients.recorder import spin_until
from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.process.child_process import ENTRY, START_TIMEOUT, NodeProcess
from cable_tracker.ros.process.environment import use_local_environment
from cable_tracker.ros.process.node_group import NodeGroup
from cable_tracker.ros.process.ros_context import client_node
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import make_header, stamp_of
from cable_tracker.sequences.messages.images import make_image
from cable_tracker.stamps import FIRST_STAMP
from cable_tracker.tracking.parameter_table import ParameterValue

BLOCK = 30
"""Frames that one of the competitors gets before it is the next one's turn."""

WARM_UP = 10
"""Frames of the first block of each that do not count."""

ANSWER_TIMEOUT, STRAGGLERS = 2.0, 0.1
"""Longest wait for the last answer of a block, and wait for further messages after it [s]."""

SETTLING = 0.3
"""Pause after a node is reset [s]."""

CAMERA = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=5, reliability=ReliabilityPolicy.BEST_EFFORT
)
"""Quality of service of a camera driver."""

RATE = 30.0
"""Rate of frames [1/s]."""


@dataclass(frozen=True, slots=True)
class NodeTrial:
    """Trial of a node: one preset on one size of frames.

    Attributes
    ----------
    name : str
        Name of the trial.
    parameters : TrackerParameters
        Parameters of the node.
    shown : Footage
        The frames.
    frames : int
        Number of frames that count.
    """

    name: str
    parameters: TrackerParameters
    shown: Footage
    frames: int


@dataclass(slots=True)
class _Target:
    """A node that is sent images, and the times of its answers [s]."""

    process: NodeProcess
    images: rclpy.publisher.Publisher
    sent: dict[int, float] = field(default_factory=dict)
    states: dict[int, float] = field(default_factory=dict)
    centrelines: dict[int, float] = field(default_factory=dict)
    cpu: float = 0.0
    answers: int = 0
    listening: bool = True

    def latencies(self, arrivals: dict[int, float], counted: set[int]) -> Percentiles | None:
        values = [
            1e3 * (arrivals[stamp] - self.sent[stamp]) for stamp in arrivals if stamp in counted
        ]
        return Percentiles.of(values) if values else None

    def share(self) -> float:
        """Return the share of one processor that the process needs at `RATE`."""
        return RATE * self.cpu / self.answers if self.answers else math.inf

    def noting(self, arrivals: dict[int, float]) -> Callable[[Message], None]:
        """Return a callback that notes when a message comes, while it is this node's turn."""

        def note(message: Message) -> None:
            if self.listening:
                arrivals[stamp_of(message.header)] = time.perf_counter()

        return note


def cpu_seconds(pid: int) -> float:
    """Return the time of the processor that a process has used [s]."""
    # The name of the program may hold anything; the numbers begin behind its bracket.
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure_node(trial: NodeTrial, advance: Callable[[int], None]) -> NodeTiming:
    """Send frames to a tracker, to a node that only answers, and to a tracker in this process.

    The three take turns in blocks. `advance` is told of every frame of each.

    Raises
    ------
    RosError
        The processes do not find each other, or one of them has died.
    """
    use_local_environment()
    with ExitStack() as stack:
        node, executor = stack.enter_context(client_node(_probe))
        bench = _Bench(trial, node, executor, advance)
        bench.echo = bench.start(stack, "echo", {}, "cable_tracker.ros.rigs.echo_node")
        bench.tracker = bench.start(stack, "tracker", _tracker_parameters(trial))
        return bench.run()


def _probe(context: Context) -> Node:
    return Node("latency_probe", namespace=f"/bench_{os.getpid()}", context=context)


def _tracker_parameters(trial: NodeTrial) -> dict[str, ParameterValue]:
    return {
        **trial.parameters.as_mapping(),
        "initial_state": format_initial_state(trial.shown.truths[0]),
        # It waits while it is the others' turn.
        "input_timeout": 3600.0,
    }


class _Bench:
    """A trial while it runs."""

    tracker: _Target
    echo: _Target

    def __init__(
        self,
        trial: NodeTrial,
        node: Node,
        executor: SingleThreadedExecutor,
        advance: Callable[[int], None],
    ) -> None:
        self._trial = trial
        self._node = node
        self._executor = executor
        self._advance = advance
        self._messages = [self._packed(image) for image in trial.shown.images]
        self._method = ConfiguredFilter(trial.name, trial.parameters).make(trial.parameters.seed)
        self._number = 0
        self._groups: list[NodeGroup] = []

    def _packed(self, image: Picture) -> Message:
        header = make_header(MESSAGES, FIRST_STAMP, "camera")
        return make_image(MESSAGES, raw_from_array(image, "mono8"), header)

    def start(
        self,
        stack: ExitStack,
        name: str,
        parameters: dict[str, ParameterValue],
        module: str = ENTRY,
    ) -> _Target:
        """Start a node under a namespace of its own, and listen to it."""
        namespace = f"{self._node.get_namespace()}/{name}"
        group = stack.enter_context(NodeGroup(namespace))
        self._groups.append(group)
        process = group.start(name, parameters, module=module)
        image = node_topics.IMAGE
        camera = publisher(self._node, image, CAMERA, name=f"{namespace}{image.global_name}")
        target = _Target(process, camera)
        for topic, arrivals in (
            (node_topics.STATE, target.states),
            (node_topics.CENTRELINE, target.centrelines),
        ):
            name = f"{namespace}{topic.global_name}"
            subscription(self._node, topic, target.noting(arrivals), qos.RESULTS, name=name)
        return target

    def run(self) -> NodeTiming:
        """Let all three take turns."""
        self._wait_for_nodes()
        for target in (self.echo, self.tracker):
            self._show(target, WARM_UP)
        self._show_in_process(WARM_UP)
        # Compiling at the first frames takes a while, and then the answers come late.
        self.tracker.listening = True
        self._settle(self.tracker)
        begin = self._stamp(self._number)
        for target in (self.echo, self.tracker):
            target.cpu, target.answers = 0.0, 0
        times: list[float] = []
        left = self._trial.frames
        while left > 0:
            count = min(left, BLOCK)
            self._show(self.echo, count)
            self._reset_tracker()
            self._show(self.tracker, count)
            times += self._show_in_process(count)
            left -= count
        return self._timing(begin, times)

    def _timing(self, begin: int, times: list[float]) -> NodeTiming:
        tracker, echo, trial = self.tracker, self.echo, self._trial
        counted = {stamp for target in (tracker, echo) for stamp in target.sent if stamp >= begin}
        round_trip = echo.latencies(echo.states, counted)
        if round_trip is None:
            raise RosError(f"the echo node answered no frame: {echo.process.last_line()}")
        asked = {stamp for stamp in tracker.sent if stamp >= begin}
        return NodeTiming(
            name=trial.name,
            size=trial.shown.size,
            particles=trial.parameters.particle_count,
            rate=RATE,
            state=tracker.latencies(tracker.states, counted),
            centreline=tracker.latencies(tracker.centrelines, counted),
            echo=round_trip,
            in_process=Percentiles.of([1e3 * each for each in times]),
            unanswered=len(asked - tracker.states.keys()),
            cpu_share=tracker.share(),
            echo_cpu_share=echo.share(),
        )

    def _wait_for_nodes(self) -> None:
        def connected() -> bool:
            return all(
                target.images.get_subscription_count() for target in (self.tracker, self.echo)
            )

        spin_until(self._executor, connected, START_TIMEOUT, self._what_has_died)
        for target in (self.echo, self.tracker):

            def answered(target: _Target = target) -> bool:
                self._send(target, 0)
                self._spin_for(1 / RATE)
                return bool(target.states)

            spin_until(self._executor, answered, START_TIMEOUT, self._what_has_died)
            self._settle(target)

    def _what_has_died(self) -> str:
        return next(filter(None, (group.what_has_died() for group in self._groups)), "")

    def _stamp(self, number: int) -> int:
        return FIRST_STAMP + number * FRAME_STEP

    def _send(self, target: _Target, index: int) -> None:
        stamp = self._stamp(self._number)
        self._number += 1
        message = self._messages[self._trial.shown.index_at(index)]
        message.header = make_header(MESSAGES, stamp, "camera")
        target.sent[stamp] = time.perf_counter()
        target.images.publish(message)

    def _show(self, target: _Target, count: int) -> None:
        """Send a block of frames at the wanted rate and wait for the answers."""
        process, begin = target.process.pid, time.perf_counter()
        used, answered = cpu_seconds(process), len(target.states)
        target.listening = True
        for index in range(count):
            self._send(target, index)
            self._spin_until_time(begin + (index + 1) / RATE)
            self._advance(1)
        self._settle(target)
        target.cpu += cpu_seconds(process) - used
        target.answers += len(target.states) - answered
        # What comes during the others' turns would be noted too late: it counts as unanswered.
        target.listening = False

    def _settle(self, target: _Target) -> None:
        """Wait for the answer to the last frame, but not for ever: frames may be dropped."""
        last, end = max(target.sent), time.perf_counter() + ANSWER_TIMEOUT
        while last not in target.states and time.perf_counter() < end:
            self._executor.spin_once(timeout_sec=0.01)
        # What else has come must not wait until it is this node's turn again.
        self._spin_for(STRAGGLERS)
        reason = self._what_has_died()
        if reason:
            raise RosError(reason)

    def _reset_tracker(self) -> None:
        """Let the tracker begin where the cable is again, as the frames do."""
        name = f"{self._node.get_namespace()}/tracker/tracker/reset"
        client = self._node.create_client(Trigger, name)
        spin_until(self._executor, client.service_is_ready, START_TIMEOUT, self._what_has_died)
        future = client.call_async(Trigger.Request())
        spin_until(self._executor, future.done, START_TIMEOUT, self._what_has_died)
        self._node.destroy_client(client)
        self._spin_for(SETTLING)

    def _show_in_process(self, count: int) -> list[float]:
        """Track a block of frames in this process at the same pace; return the times [s].

        A tracker that is too slow for the pace sees fewer frames, as in a node.
        """
        times: list[float] = []
        self._method.initialise(GivenState.around(self._trial.shown.truths[0]))
        begin = time.perf_counter()
        for index in range(count):
            image = self._trial.shown.images[self._trial.shown.index_at(index)]
            start = time.perf_counter()
            self._method.process(image, self._stamp(self._number))
            times.append(time.perf_counter() - start)
            self._number += 1
            time.sleep(max(begin + (index + 1) / RATE - time.perf_counter(), 0.0))
            if time.perf_counter() > begin + count / RATE:
                break
        self._advance(count)
        return times

    def _spin_for(self, seconds: float) -> None:
        self._spin_until_time(time.perf_counter() + seconds)

    def _spin_until_time(self, end: float) -> None:
        while (left := end - time.perf_counter()) > 0.0:
            self._executor.spin_once(timeout_sec=left)
