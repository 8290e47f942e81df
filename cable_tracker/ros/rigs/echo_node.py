"""A node that answers every image at once with what the tracker would publish, and tracks nothing.

Its latency is that of DDS and rclpy alone; `cable-tracker dev bench --dds` subtracts it.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from cable_tracker.cable.model.state import STATE_SIZE, CableState
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.process.process_node import ProcessNode, run_node
from cable_tracker.ros.process.stop_request import stop_on_signals
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.cable import make_centreline, make_state
from cable_tracker.sequences.messages.factory import Message

ANSWER = CableState(0.0, 0.0, 40.0)


class EchoNode(ProcessNode):
    """Publishes `centreline` and `state` for each `image`, with its header.

    Parameters
    ----------
    **node_arguments
        Passed on to `rclpy.node.Node`.
    """

    def __init__(self, **node_arguments: Any) -> None:  # noqa: ANN401
        super().__init__("echo", **node_arguments)
        self._covariance = np.eye(STATE_SIZE)
        self._state = publisher(self, node_topics.STATE, qos.LATEST_RESULT)
        self._centreline = publisher(self, node_topics.CENTRELINE, qos.RESULTS)
        subscription(self, node_topics.IMAGE, self.on_image, qos.image_input("best_effort"))

    def on_image(self, message: Message) -> None:
        """Answer."""
        header = message.header
        self._centreline.publish(make_centreline(MESSAGES, header, ANSWER, self._covariance))
        self._state.publish(make_state(MESSAGES, header, ANSWER, np.ones(4)))


if __name__ == "__main__":
    sys.exit(run_node(lambda context: EchoNode(context=context), sys.argv[1:], stop_on_signals()))
