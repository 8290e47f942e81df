"""Follow one frame through the code, from the message to `centreline`, and count.

    python docs/walk.py

A tracker node with the default preset is given the frames of a simulated dive until it tracks; the
calls of Python functions of this package during the next one, until `centreline` is published, are
printed in their order, each file and function once, and counted. What compiled code does inside is
not counted: profilers of Python do not see it.
"""

from __future__ import annotations

import sys
import time
from itertools import pairwise
from pathlib import Path
from types import FrameType

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.serialization import serialize_message
from rclpy.signals import SignalHandlerOptions

from cable_tracker import arrays
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import subscription
from cable_tracker.ros.messages.rclpy_messages import RclpyMessages
from cable_tracker.ros.nodes.frame_outputs import FrameOutputs
from cable_tracker.ros.nodes.tracker_node import TrackerNode
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_image
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate
from cable_tracker.tracking.status import TrackingStatus

PACKAGE = Path(arrays.__file__).parent
FRAMES = 60


class Walk:
    """Calls of functions of this package until `centreline` is published, in order."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, str]] = []
        self._is_over = False

    def __call__(self, frame: FrameType, event: str, _argument: object) -> None:
        """Record a call; a profile function for `sys.setprofile`."""
        path = Path(frame.f_code.co_filename)
        if self._is_over or not path.is_relative_to(PACKAGE):
            return
        if event == "call":
            self.calls.append((str(path.relative_to(PACKAGE)), frame.f_code.co_qualname))
        self._is_over = event == "return" and frame.f_code is FrameOutputs.publish_results.__code__


def serialised(frame: Frame) -> bytes:
    """Return a frame as the serialised message that a node receives."""
    factory = RclpyMessages()
    header = make_header(factory, frame.stamp, "camera")
    message: bytes = serialize_message(make_image(factory, frame.image, header))
    return message


def walk_of_last(messages: list[bytes], context: Context) -> Walk:
    """Track on all messages, and follow the last one; a controller subscribes to `centreline`."""
    node, controller = TrackerNode(context=context), Node("controller", context=context)
    subscription(controller, node_topics.CENTRELINE, lambda _: None, qos.RESULTS)
    while not node.count_subscribers("centreline"):
        time.sleep(0.01)
    node.wait_until_warm()
    for message in messages[:-1]:
        node.on_image(message, {})
    if node.status != TrackingStatus.TRACKING.value:
        sys.exit("the cable was not found; nothing to follow")
    walk = Walk()
    sys.setprofile(walk)
    node.on_image(messages[-1], {})
    sys.setprofile(None)
    for each in (node, controller):
        each.destroy_node()
    return walk


def main() -> None:
    """Print the walk."""
    frames = simulate(SimulationSettings(frame_count=FRAMES))
    messages = [serialised(frame) for frame in frames]
    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    try:
        calls = walk_of_last(messages, context).calls
    finally:
        rclpy.try_shutdown(context=context)
    for path, function in dict.fromkeys(calls):
        print(f"{path}: {function}")
    switches = sum(before[0] != after[0] for before, after in pairwise(calls))
    files = {path for path, _ in calls}
    print(f"{len(calls)} calls, {len(files)} files, {switches} switches of file")


if __name__ == "__main__":
    main()
