"""Base of a closed loop's recorder: the nodes of a run, their messages, and when the run ends."""

from __future__ import annotations

import os
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, ClassVar, Final, Generic, TypeAlias, TypeVar

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from cable_tracker.errors import RosError
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.ros.health.tracker_health import TrackerHealth, is_guidance
from cable_tracker.ros.process.child_process import NodeProcess
from cable_tracker.ros.process.environment import use_local_environment
from cable_tracker.ros.process.node_group import NodeGroup
from cable_tracker.ros.process.ros_context import client_node
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.sequences.node_topics import CLOCK, NodeTopic

COMMAND: Final = node_topics.COMMAND.name
RELEASED: Final = "recorded_cmd_vel"
"""Topic on which a simulator in lockstep awaits commands."""

MOST_WAITING = 100
"""Commands that may wait. In lockstep it is one or two; in real time nothing takes them."""

SETTLE_TIME = 60.0
"""Longest wait of what steers in lockstep for all that the tracker's report announces [s]."""

SILENCE_TIMEOUT = 300.0
"""Time without a frame, or before the first, after which a run is given up [s]."""

QUIET_TURNS = 50
"""Number of turns of the executor without a message after which its queues are empty.

That a process has ended says that its messages have arrived, not that they have been taken: they
wait in the executor's queues. Turns tell, on a busy machine, too; time does not. A turn runs one
callback. What else is ready, diagnostics or a service, takes turns with the messages of the run, so
that a few turns would do.
"""

Row = TypeVar("Row")
VideoFrame = TypeVar("VideoFrame")

FrameMessages: TypeAlias = dict[NodeTopic, Message]
"""Messages about one frame, as far as they have come."""


class ReleasedCommands:
    """Holds each command back until all messages about its frame have been recorded.

    The nodes of a loop drive each other. A recorder that only listened could fall behind them by
    more messages than they keep for it, where the machine gives it no processor for a while.

    Parameters
    ----------
    node : Node
        The recorder.

    Attributes
    ----------
    received : int
        Number of commands received.
    """

    def __init__(self, node: Node) -> None:
        self.received = 0
        self._released = 0
        self._waiting: deque[Message] = deque(maxlen=MOST_WAITING)
        self._publisher = publisher(node, node_topics.COMMAND, qos.RESULTS, name=RELEASED)
        subscription(node, node_topics.COMMAND, self._receive, qos.EVERYTHING)

    def _receive(self, message: Message) -> None:
        self.received += 1
        self._waiting.append(message)

    def release(self, recorded: int) -> None:
        """Publish the commands whose frames are recorded.

        Parameters
        ----------
        recorded : int
            Number of frames recorded completely so far; each has one command.
        """
        while (
            self._waiting and self._released < recorded and self._publisher.get_subscription_count()
        ):
            self._publisher.publish(self._waiting.popleft())
            self._released += 1


class RunRecorder(Node, ABC, Generic[VideoFrame]):  # type: ignore[misc]
    """Records a run of several nodes: the messages about each frame, by their stamps.

    Parameters
    ----------
    name : str
        Name of the node.
    context : Context
        rclpy context of this process.
    namespace : str
        Namespace of the nodes that it listens to.

    Attributes
    ----------
    received : int
        Number of messages received that were to be recorded.
    """

    RECORDED: ClassVar[tuple[NodeTopic, ...]]
    """Topics that are always listened to."""

    PICTURE: ClassVar[NodeTopic]
    """What is shown in the video, and kept no longer than that."""

    SENT: ClassVar[frozenset[NodeTopic]]
    """Those of the simulator: one of them tells that it has sent a frame, or begun to."""

    def __init__(self, name: str, context: Context, namespace: str) -> None:
        super().__init__(name, context=context, namespace=namespace)
        self.received = 0
        self._frames: dict[int, FrameMessages] = {}
        self._open: dict[int, FrameMessages] = {}
        self._last = -1
        self._taken = 0
        self._health = TrackerHealth()
        self._commands = ReleasedCommands(self)
        subscription(self, node_topics.DIAGNOSTICS, self._on_diagnostics, qos.EVERYTHING)
        for topic in self.RECORDED:
            self._record(topic)

    def _record(self, topic: NodeTopic) -> None:
        subscription(self, topic, partial(self._receive, topic), qos.EVERYTHING)

    def _receive(self, topic: NodeTopic, message: Message) -> None:
        self.received += 1
        stamp = stamp_of(message.header)
        if stamp not in self._frames:
            self._frames[stamp] = self._open[stamp] = {}
        self._frames[stamp][topic] = message

    @abstractmethod
    def _is_complete(self, frame: FrameMessages) -> bool:
        """Tell whether all messages about a frame have come."""

    @abstractmethod
    def _video_frame(self, stamp: int, frame: FrameMessages) -> VideoFrame:
        """Return what the video shows of a complete frame."""

    def take(self) -> list[VideoFrame]:
        """Return the frames that have become complete, in order, each once.

        A frame that the tracker has left out is passed over when a later one is complete. In
        lockstep the simulator goes on when a frame is complete.
        """
        complete = sorted(stamp for stamp, frame in self._open.items() if self._is_complete(frame))
        frames = [
            self._video_frame(stamp, self._open[stamp]) for stamp in complete if stamp > self._last
        ]
        self._last = max([self._last, *complete])
        self._taken += len(frames)
        self._commands.release(self._taken)
        for stamp in [stamp for stamp in self._open if stamp <= self._last]:
            # Pictures are large, and a run has thousands.
            self._open.pop(stamp).pop(self.PICTURE, None)
        return frames

    def is_settled(self) -> bool:
        """Tell whether all messages about the frames sent have come, and were taken."""
        return not any(self.SENT & frame.keys() for frame in self._open.values())

    def _on_diagnostics(self, message: Any) -> None:  # noqa: ANN401
        self._health.take(message)
        for status in filter(is_guidance, message.status):
            self._note_mode(stamp_of(message.header), str(status.message))

    def _note_mode(self, stamp: int, mode: str) -> None:
        """Keep the mode that the controller or follower reports at a stamp [ns]."""


AnyRecorder = TypeVar("AnyRecorder", bound=RunRecorder[Any])


@contextmanager
def closed_loop(
    name: str, make: Callable[[Context, str], AnyRecorder]
) -> Iterator[tuple[AnyRecorder, SingleThreadedExecutor, NodeGroup]]:
    """Make a recorder, its executor and a group of nodes, in a namespace of this process's own.

    Parameters
    ----------
    name : str
        Part of the namespace.
    make : callable
        Makes the recorder, from context and namespace.

    Raises
    ------
    RosError
        ROS does not start.
    """
    use_local_environment()
    namespace = f"/cable_tracker_{name}_{os.getpid()}"
    with (
        client_node(lambda context: make(context, namespace)) as (recorder, executor),
        NodeGroup(namespace, {CLOCK.global_name: CLOCK.name}) as group,
    ):
        yield recorder, executor, group


def listen_to_the_end(
    recorder: RunRecorder[VideoFrame],
    executor: SingleThreadedExecutor,
    group: NodeGroup,
    simulator: NodeProcess,
    *,
    show: Callable[[VideoFrame], None],
    has_settled: Callable[[float], bool],
) -> None:
    """Spin until the simulator has ended, and all messages of the nodes have been received.

    Parameters
    ----------
    recorder : RunRecorder
        Listens.
    executor : SingleThreadedExecutor
        Runs its callbacks.
    group : NodeGroup
        The nodes of the run.
    simulator : NodeProcess
        The one of them that ends by itself.
    show : callable
        Takes what the video shows of a frame, once for each.
    has_settled : callable
        Tells whether all has come, from the time since the end of the simulator [s].

    Raises
    ------
    RosError
        A node has died, or nothing comes.
    """
    last_frame = time.monotonic()
    ended: float | None = None
    quiet_turns = 0
    while ended is None or quiet_turns < QUIET_TURNS or not has_settled(time.monotonic() - ended):
        received = recorder.received
        executor.spin_once(timeout_sec=0.02)
        complaint = group.what_has_died()
        for frame in recorder.take():
            show(frame)
            last_frame = time.monotonic()
        quiet_turns = quiet_turns + 1 if ended is not None and recorder.received == received else 0
        if ended is None and not simulator.running:
            ended = time.monotonic()
        if not complaint and time.monotonic() - last_frame > SILENCE_TIMEOUT:
            complaint = (
                f"nothing came for {SILENCE_TIMEOUT:g} s; is the machine too busy? run it again"
            )
        if complaint:
            raise RosError(complaint)


def need_rows(rows: list[Row]) -> list[Row]:
    """Return the table of a run, if it has any rows.

    Raises
    ------
    RosError
        It has none.
    """
    if not rows:
        raise RosError("the simulator has sent no frames; run it again on an idle machine")
    return rows
