"""Context manager of a client node in this process."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

NodeType = TypeVar("NodeType", bound=Node)


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
    """
    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    try:
        executor = SingleThreadedExecutor(context=context)
        node = make(context)
        executor.add_node(node)
        try:
            yield node, executor
        finally:
            executor.shutdown()
            node.destroy_node()
    finally:
        rclpy.try_shutdown(context=context)
