"""Collects what a tracker node publishes, frame by frame."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import deserialize_message

from cable_tracker.errors import RosError
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.ros.health.tracker_health import TrackerHealth
from cable_tracker.ros.messages.announced_topics import announced_topics
from cable_tracker.ros.messages.rclpy_messages import message_class
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.frame_report import report_status
from cable_tracker.sequences.node_topics import NodeTopic, TrackerTopics

ACKNOWLEDGED = "recorded_state"
"""Topic on which a lockstep replay awaits the tracker's `state`, once it is recorded."""

LATE_TURNS = 20
"""Number of turns of the executor after a time-out; each takes one message."""

Result = TypeVar("Result")


@dataclass(frozen=True, slots=True, eq=False)
class RecordedFrame:
    """All messages about one frame, serialised.

    Attributes
    ----------
    messages : mapping
        CDR bytes by topic.
    status : str
        The frame's status.
    diagnostics : sequence of bytes
        Serialised DiagnosticArray messages received since the frame before.
    """

    messages: Mapping[NodeTopic, bytes]
    status: str
    diagnostics: Sequence[bytes] = ()

    def read(self, topic: NodeTopic) -> Message:
        """Deserialise one of the messages."""
        return deserialize_message(self.messages[topic], message_class(topic.type_name))


class Recorder(Node):  # type: ignore[misc]
    """Subscribes to a tracker's outputs and puts together those of the same frame.

    Every topic keeps its order, but topics overtake each other. Which of them speak of a frame
    follows from its report.

    Parameters
    ----------
    context : Context
        rclpy context of this process.
    namespace : str
        Namespace of the tracker.
    topics : TrackerTopics
        Topics of the tracker.
    """

    def __init__(self, context: Context, namespace: str, topics: TrackerTopics) -> None:
        super().__init__("recorder", context=context, namespace=namespace)
        self._topics = topics
        self._queues: dict[NodeTopic, deque[bytes]] = {
            topic: deque() for topic in (*topics.of_frame, node_topics.DIAGNOSTICS)
        }
        for topic in self._queues:
            subscription(self, topic, partial(self._keep, topic), qos.EVERYTHING, raw=True)
        self._acknowledged = publisher(
            self, node_topics.STATE, qos.LATEST_RESULT, name=ACKNOWLEDGED
        )

    def _keep(self, topic: NodeTopic, message: bytes) -> None:
        self._queues[topic].append(message)

    def is_warming(self) -> bool:
        """Tell whether the tracker is compiling, and log it now and then."""
        if not self._health().warming():
            return False
        self.get_logger().info(
            "waiting: the tracker is WARMING UP; once per installation this takes about half a"
            " minute of a laptop's processor",
            throttle_duration_sec=5.0,
        )
        return True

    def _health(self) -> TrackerHealth:
        """Return the trackers' state by the latest diagnostics; empty before the first."""
        health, diagnostics = TrackerHealth(), self._queues[node_topics.DIAGNOSTICS]
        if diagnostics:
            kind = message_class(node_topics.DIAGNOSTICS.type_name)
            health.take(deserialize_message(diagnostics[-1], kind))
        return health

    def is_subscribed(self) -> bool:
        """Tell whether the tracker is ready and has seen all our subscriptions.

        Both stand in its diagnostics.
        """
        health = self._health()
        own = [self.resolve_topic_name(each.name) for each in self._queues]
        counts = [health.readers[name] for name in own if name in health.readers]
        return health.is_warm() and bool(counts) and all(counts)

    def take(self) -> RecordedFrame | None:
        """Return the next frame if all messages about it have come."""
        reports = self._queues[self._topics.report]
        if not reports:
            return None
        report = deserialize_message(reports[0], message_class(self._topics.report.type_name))
        topics = announced_topics(self._topics, report)
        if not all(self._queues[topic] for topic in topics):
            return None
        messages = {topic: self._queues[topic].popleft() for topic in topics}
        return RecordedFrame(messages, report_status(report), self.take_diagnostics())

    def take_diagnostics(self) -> list[bytes]:
        """Return the diagnostics that have come since the last call."""
        queue = self._queues[node_topics.DIAGNOSTICS]
        messages = list(queue)
        queue.clear()
        return messages

    def acknowledge(self, state: Message) -> None:
        """Let the replay go on."""
        self._acknowledged.publish(state)


def spin_until(
    executor: SingleThreadedExecutor,
    condition: Callable[[], Result | None],
    timeout: float,
    complaint: Callable[[], str],
    may_take_longer: Callable[[], bool] = lambda: False,
) -> Result:
    """Run callbacks until a condition holds, and return what it has returned then.

    When the time is over, what waits in the queues counts still: a process that was held up itself
    finds there what has come meanwhile.

    Parameters
    ----------
    executor : SingleThreadedExecutor
        Runs the callbacks.
    condition : callable
        Ends the spinning once it returns something true.
    timeout : float
        For how long [s].
    complaint : callable
        Returns what has gone wrong; empty while nothing has.
    may_take_longer : callable
        While it is true the time-out begins anew.

    Raises
    ------
    RosError
        It does not hold in time, or `complaint` has something to say before.
    """
    deadline, late_turns = time.monotonic() + timeout, 0
    while not (result := condition()):
        executor.spin_once(timeout_sec=0.05)
        if may_take_longer():
            deadline = time.monotonic() + timeout
        late_turns = late_turns + 1 if time.monotonic() > deadline else 0
        reason = complaint()
        if not reason and late_turns > LATE_TURNS:
            reason = f"nothing came for {timeout:g} s"
        if reason:
            raise RosError(reason)
    return result
