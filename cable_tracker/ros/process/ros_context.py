"""Starting ROS in a process: a context of rclpy, a node in it, and a client for a block of code."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TypeVar

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from cable_tracker.errors import RosError, one_line
from cable_tracker.ros.missing_ros import missing_ros_message

NodeType = TypeVar("NodeType", bound=Node)

PLAIN_FILE = "before ros__parameters"
"""In rcl's words about a parameter file that begins with values."""

PLAIN_FILE_ADVICE = (
    "a plain parameter file has to stand under the node's name and ros__parameters, as in"
    " `tracker:` / `  ros__parameters:` / `    camera_pitch: 70.0`"
)


def started_context(arguments: Sequence[str] = ()) -> Context:
    """Return a context that has started; signals are left to the process.

    Parameters
    ----------
    arguments : sequence of str
        Command line of a node; a client has none.

    Raises
    ------
    RosError
        ROS does not start.
    """
    context = Context()
    try:
        rclpy.init(
            args=list(arguments),
            context=context,
            signal_handler_options=SignalHandlerOptions.NO,
        )
    except RuntimeError as error:
        # rclpy's own errors derive from it: a bad parameter file, unknown arguments.
        where = "the --ros-args" if arguments else "its environment"
        message = f"ROS does not start; look at {where} ({one_line(error)})"
        if PLAIN_FILE in str(error):
            message += f"; {PLAIN_FILE_ADVICE}"
        raise RosError(message) from error
    return context


def made_node(make: Callable[[Context], NodeType], context: Context) -> NodeType:
    """Return a node that is made in a context.

    Raises
    ------
    RosError
        The middleware refuses it, or the package of its messages is not installed.
    """
    try:
        return make(context)
    except ImportError as error:
        # Of a topic's messages, which are looked up by the name of their type.
        message = missing_ros_message(error)
        if not message:
            raise
        raise RosError(message) from error
    except rclpy_implementation.RCLError as error:
        # Security that it was not built with, a domain out of range.
        raise RosError(
            f"ROS cannot make the node ({one_line(error)}); check what stands behind --ros-args,"
            " and the environment"
        ) from error


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
