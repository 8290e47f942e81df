"""Publishes on /diagnostics how a node with a camera is doing."""

from __future__ import annotations

import math
import time

import numpy as np
from rclpy.node import Node

from cable_tracker.arrays import Image
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publisher
from cable_tracker.ros.health.diagnostics import FrameStatistics, frame_values, make_diagnostics
from cable_tracker.ros.health.tracker_health import READERS_OF
from cable_tracker.ros.health.watched_endpoints import WatchedEndpoints
from cable_tracker.ros.inputs.image_input import ImageInput
from cable_tracker.ros.inputs.input_watch import InputWatch
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.tracking.level_gain import amplified, level_gain

BLACK, WHITE = 2.0, 253.0
"""Grey levels up to and from which nothing can be told apart."""

MOST = 0.9
"""Share of pixels that makes a picture black or saturated."""


class CameraDiagnostics:
    """Publishes the node's status and the figures of its input, from time to time or when asked.

    Parameters
    ----------
    node : Node
        The node.
    statistics : FrameStatistics
        Statistics of the received frames.
    watch : InputWatch
        Knows the last picture.
    camera : ImageInput
        Knows who publishes its topic.
    endpoints : WatchedEndpoints
        Those of images, starts and results.

    Attributes
    ----------
    period : float
        Time between two messages [s].
    """

    def __init__(
        self,
        node: Node,
        statistics: FrameStatistics,
        watch: InputWatch,
        camera: ImageInput,
        endpoints: WatchedEndpoints,
    ) -> None:
        self._node = node
        self._statistics = statistics
        self._watch = watch
        self._camera = camera
        self._endpoints = endpoints
        self.period = 1.0
        self._since = -math.inf
        self._publisher = publisher(
            node, node_topics.DIAGNOSTICS, qos.RESULTS, name=node_topics.DIAGNOSTICS.global_name
        )

    def is_due(self, now: float) -> bool:
        """Tell whether the next message is due, on the monotonic clock [s]."""
        return now >= self._since + self.period

    def _count_from(self, now: float) -> None:
        """Let the next message be due a period after this one was, not after it is sent [s].

        The watchdog comes later than it was due, and would make every period longer.
        """
        if not self.is_due(now):
            return  # One that is sent out of turn changes nothing.
        due = self._since + self.period
        self._since = due if now < due + self.period else now

    def publish(self, status: str, figures: dict[str, str]) -> None:
        """Publish a status of `LEVELS`, the node's own figures, those of its input and readers."""
        now = time.monotonic()
        self._count_from(now)
        values = frame_values(self._statistics, now) | figures
        values["picture"] = remark_on(self._watch.picture)
        values["same picture for [s]"] = f"{self._watch.same_for:.1f}"
        values["QoS mismatch"] = self._endpoints.mismatches()
        values["several cameras"] = self._camera.several_cameras()
        for result in self._endpoints.publishers:
            readers = result.get_subscription_count()
            values[f"{READERS_OF}{result.topic_name}"] = str(readers)
        header = make_header(MESSAGES, self._node.get_clock().now().nanoseconds, "")
        name = self._node.get_fully_qualified_name()
        self._publisher.publish(make_diagnostics(MESSAGES, header, name, status, values))


def remark_on(picture: Image | None) -> str:
    """Say what is odd about a picture; empty where nothing is.

    Such pictures are not refused: the filters find nothing in them, and say so.

    Parameters
    ----------
    picture : Image or None
        Grey levels 0..255, shape (H, W), or colours (H, W, 3), whose channels are looked at
        together; None before the first.
    """
    if picture is None:
        return ""
    low, high = float(picture.min()), float(picture.max())
    if low == high:
        return f"all pixels are the same ({low:g} of 255)"
    # Of more than eight bits, a scene can be told apart within a single grey level.
    dark = float(np.mean(amplified(picture, level_gain(1.0, picture)) <= BLACK))
    bright = float(np.mean(picture >= WHITE))
    if dark >= MOST:
        return f"black: {100 * dark:.0f} % of the pixels"
    if bright >= MOST:
        return f"saturated: {100 * bright:.0f} % of the pixels are white"
    return ""
