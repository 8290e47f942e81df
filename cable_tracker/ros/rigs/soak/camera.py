"""The camera of a soak test: sends frames, hears the answers, and looks at every number in them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from sensor_msgs.msg import Image

from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.ros.rigs.soak.checks import (
    Check,
    markers_are_finite,
    picture_is_whole,
    report_is_finite,
    state_is_finite,
)
from cable_tracker.ros.rigs.soak.record import SoakRecord
from cable_tracker.ros.rigs.soak.soaked_node import SoakedNode
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import stamp_of
from cable_tracker.sequences.node_topics import NodeTopic

BEST_EFFORT = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT
)
TURN = 0.02
"""Longest time that the executor sleeps [s]."""


class SoakCamera(Node):  # type: ignore[misc]
    """Sends frames to a tracker in its namespace and checks what comes back.

    Parameters
    ----------
    context : Context
        Context of rclpy.
    namespace : str
        Namespace of the tracker.
    record : SoakRecord
        Record of the observations.
    soaked : SoakedNode
        The tracker.

    Attributes
    ----------
    answers : int
        Number of `state` messages received.
    last_stamp : int or None
        Stamp of the last of them [ns].
    last_claims : bool
        Whether it held a cable, or a target.
    status : str
        The latest on /diagnostics.
    """

    def __init__(
        self,
        context: Context,
        namespace: str,
        record: SoakRecord,
        soaked: SoakedNode,
    ) -> None:
        super().__init__("soak", context=context, namespace=namespace)
        self._soaked = soaked
        self._record = record
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self)
        self.answers = 0
        self.last_stamp: int | None = None
        self.last_claims = False
        self.status = ""
        self._raw = publisher(self, node_topics.IMAGE, qos.PICTURES)
        self._compressed = publisher(self, node_topics.COMPRESSED_IMAGE, qos.PICTURES)
        self.mark = publisher(self, soaked.mark, qos.RESULTS)
        self._viewers: list[Subscription] = []
        subscription(self, node_topics.STATE, self._on_state, qos.RESULTS)
        for topic, check in soaked.heard:
            self._listen(topic, topic.name, check)
        report = node_topics.FRAME_REPORT
        self._listen(report, report.of_node(soaked.name), report_is_finite)
        subscription(self, node_topics.DIAGNOSTICS, self._on_diagnostics, qos.RESULTS)

    def _listen(self, topic: NodeTopic, name: str, check: Check) -> Subscription:
        def hear(message: Message) -> None:
            self._check(name, check(message))

        return subscription(self, topic, hear, qos.PICTURES, name=name)

    def _check(self, topic: str, holds: bool) -> None:
        self._record.messages[topic] += 1
        if not holds:
            self._record.broken(f"a number on {topic} is not finite, or a picture is empty")

    def _on_state(self, message: Message) -> None:
        self._check(node_topics.STATE.name, state_is_finite(message))
        self.answers += 1
        self._record.answered += 1
        self.last_stamp = stamp_of(message.header)
        self.last_claims = len(message.position) > 0

    def _on_diagnostics(self, message: Message) -> None:
        self._check(node_topics.DIAGNOSTICS.name, report_is_finite(message))
        self.status = message.status[0].message if message.status else self.status

    def watch_pictures(self) -> None:
        """Subscribe to everything that is built for viewers only."""
        markers = node_topics.MARKERS
        self._viewers = [
            self._listen(markers, markers.name, markers_are_finite),
            *(
                self._listen(topic, topic.of_node(self._soaked.name), picture_is_whole)
                for topic in (node_topics.RAW_OVERLAY, node_topics.OVERLAY)
            ),
        ]

    def leave_pictures(self) -> None:
        """Unsubscribe again."""
        for viewer in self._viewers:
            self.destroy_subscription(viewer)
        self._viewers = []

    def send(self, message: Message) -> None:
        """Publish a frame, compressed or not."""
        camera = self._raw if isinstance(message, Image) else self._compressed
        camera.publish(message)
        self._record.sent += 1

    def send_with_other_qos(self, messages: Iterable[Message]) -> None:
        """Publish frames like a camera that is less reliable than the tracker asks for."""
        messages = list(messages)
        is_raw = isinstance(messages[0], Image)
        topic = node_topics.IMAGE if is_raw else node_topics.COMPRESSED_IMAGE
        camera = publisher(self, topic, BEST_EFFORT)
        for message in messages:
            camera.publish(message)
            self.pass_time(TURN)
        self.destroy_publisher(camera)

    def spin_until(self, condition: Callable[[], bool], patience: float) -> bool:
        """Run callbacks until a condition holds; tell whether it came to hold in time."""
        deadline = time.monotonic() + patience
        while not condition():
            if time.monotonic() > deadline:
                return False
            self._executor.spin_once(timeout_sec=TURN)
        return True

    def pass_time(self, seconds: float) -> None:
        """Run callbacks for some time."""
        self.spin_until(lambda: False, seconds)

    def call(self, kind: type, service: str, request: Message, patience: float) -> Message | None:
        """Call a service of the tracker; None if no answer comes in time."""
        client = self.create_client(kind, service)
        try:
            if not self.spin_until(client.service_is_ready, patience):
                return None
            future = client.call_async(request)
            self.spin_until(future.done, patience)
            return future.result() if future.done() else None
        finally:
            self.destroy_client(client)

    def close(self) -> None:
        """Destroy the node."""
        self._executor.shutdown()
        self.destroy_node()
