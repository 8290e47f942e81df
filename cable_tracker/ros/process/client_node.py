"""Context manager of a client node in this process."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor

from cable_tracker.ros.process.ros_context import NodeType, made_node, started_context


@contextmanager
def client_node(
    make: Callable[[Context], NodeType],
) -> Iterator[tuple[NodeType, SingleThreadedExecutor]]:
    """Make a node with a context and an executor of its own; all end with the block.

    Signals are left to the process, and its command line is not read.

    Parameters
    ----------
    make : callable
        Makes the node in the context that it is given.

    Raises
    ------
    RosError
        ROS does not start, or the middleware refuses the node.
    """
    context = started_context()
    try:
        executor = SingleThreadedExecutor(context=context)
        node = made_node(make, context)
        executor.add_node(node)
        try:
            yield node, executor
        finally:
            executor.shutdown()
            node.destroy_node()
    finally:
        rclpy.try_shutdown(context=context)
