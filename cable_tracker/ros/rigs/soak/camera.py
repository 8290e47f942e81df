"""The camera of a soak test: sends frames, and checks that the answers hold finite numbers."""

from __future__ import annotations

import math
import time
from array import array
from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from sensor_msgs.msg import CompressedImage, Image, PointCloud2

from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publisher, subscription
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

NOT_FINITE = {"nan", "inf", "-inf"}
"""Words of texts that stand for such numbers."""


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
        self.start = publisher(self, soaked.topics.start, qos.RESULTS)
        self._viewers: list[Subscription] = []
        subscription(self, node_topics.STATE, self._on_state, qos.RESULTS)
        for topic in (*soaked.topics.results, *soaked.topics.metres, node_topics.PARTICLES):
            self._listen(topic, topic.name)
        self._listen(soaked.topics.report, soaked.topics.report.name)
        subscription(self, node_topics.DIAGNOSTICS, self._on_diagnostics, qos.RESULTS)

    def _listen(self, topic: NodeTopic, name: str) -> Subscription:
        return subscription(self, topic, partial(self._check, name), qos.PICTURES, name=name)

    def _check(self, topic: str, message: Message) -> None:
        self._record.messages[topic] += 1
        is_empty_picture = isinstance(message, Image | CompressedImage) and not message.data
        if is_empty_picture or not is_finite(message):
            self._record.broken(f"a number on {topic} is not finite, or a picture is empty")

    def _on_state(self, message: Message) -> None:
        self._check(node_topics.STATE.name, message)
        self.answers += 1
        self._record.answered += 1
        self.last_stamp = stamp_of(message.header)
        self.last_claims = len(message.position) > 0

    def _on_diagnostics(self, message: Message) -> None:
        self._check(node_topics.DIAGNOSTICS.name, message)
        self.status = message.status[0].message if message.status else self.status

    def watch_pictures(self) -> None:
        """Subscribe to everything that is built for viewers only."""
        markers = node_topics.MARKERS
        self._viewers = [
            self._listen(markers, markers.name),
            *(
                self._listen(topic, topic.of_node(self._soaked.topics.node))
                for topic in (node_topics.RAW_OVERLAY, self._soaked.topics.overlay)
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


def is_finite(value: object) -> bool:
    """Tell whether all numbers in a message are finite, those in texts and clouds, too."""
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, str):
        return not NOT_FINITE & set(value.lower().split())
    if isinstance(value, PointCloud2):
        # Those of our nodes hold float32 alone.
        return bool(np.isfinite(np.frombuffer(memoryview(value.data).cast("B"), "<f4")).all())
    if hasattr(value, "get_fields_and_field_types"):
        return all(is_finite(getattr(value, name)) for name in value.get_fields_and_field_types())
    if isinstance(value, np.ndarray | array):
        return bool(np.isfinite(value).all())
    return not isinstance(value, Sequence) or all(is_finite(each) for each in value)
