"""Keeps looking for endpoints whose quality of service does not fit ours, and reports them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.node import Node

from cable_tracker.ros.health.qos_mismatch import InputProfile, input_mismatches, output_mismatches


class MismatchReport:
    """Says which endpoints cannot hear which, until all of them can.

    Parameters
    ----------
    node : Node
        The node whose topics are looked at.
    inputs, outputs : callable
        Return our profiles, by full name of the topic.
    """

    def __init__(
        self,
        node: Node,
        inputs: Callable[[], Mapping[str, InputProfile]],
        outputs: Callable[[], Mapping[str, Any]],
    ) -> None:
        self._node = node
        self._inputs = inputs
        self._outputs = outputs
        self._is_looking = False
        self._found: list[str] = []

    def on_event(self, event: Any) -> None:  # noqa: ANN401
        """Look now, and again until nothing is found; the callback of the middleware's event."""
        # The event names no endpoint: which it is stands in the graph.
        self._is_looking = True
        self.look()

    def look(self) -> None:
        """Look for mismatches if there is reason to, and log those that are new."""
        if not self._is_looking:
            return
        node = self._node
        found = [
            sentence
            for topic, profile in self._inputs().items()
            for sentence in input_mismatches(node, topic, profile)
        ]
        for topic, profile in self._outputs().items():
            found += output_mismatches(node, topic, profile)
        for sentence in found:
            if sentence not in self._found:
                node.get_logger().error(sentence)
        # The graph may learn of an endpoint only after the event: an empty answer is not the last.
        self._is_looking = bool(found) or not self._found
        self._found = found

    def words(self) -> str:
        """Return all that was found at the last look, in one line."""
        return "; ".join(self._found)
