"""The life of a node's process: start, spin, stop on a signal, exit code."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable, Sequence

import rclpy
from rclpy.context import Context
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.utilities import remove_ros_args

from cable_tracker.errors import (
    EXIT_USER_ERROR,
    CableTrackerError,
    ParameterError,
    one_line,
)
from cable_tracker.ros.process.environment import check_profile
from cable_tracker.ros.process.ros_context import made_node, started_context
from cable_tracker.ros.process.shared_memory import remove_dead_segments
from cable_tracker.ros.process.stop_request import StopRequest

WAKE_UP = 0.1
"""Longest time that the executor sleeps before it looks whether to stop [s]."""


class ProcessNode(Node):  # type: ignore[misc]
    """A node that makes up a process."""

    finished = False
    """Set by the node when its work is done."""

    def seconds_until_due(self) -> float:
        """Return how long the executor may sleep [s]."""
        return WAKE_UP

    def work(self) -> None:
        """Do the work that is due outside callbacks; called at least every 0.1 s."""


def run_node(
    make_node: Callable[[Context], ProcessNode], arguments: Sequence[str] | None, stop: StopRequest
) -> int:
    """Make a node, spin it until it has finished or a signal comes, and return the exit code.

    Our own signal handlers only take note: rclpy's would make the context invalid in the middle of
    a callback, and the next publish would raise.
    """
    try:
        check_profile()
        remove_dead_segments()
        context = started_context(sys.argv if arguments is None else arguments)
    except CableTrackerError as error:
        return _print_error(error)
    node: ProcessNode | None = None
    executor = SingleThreadedExecutor(context=context)
    try:
        if not stop.requested:
            node = made_node(make_node, context)
            executor.add_node(node)
            # What is loaded by now stays: the collector need not look through it between frames.
            gc.freeze()
            _spin(node, executor, stop)
    except CableTrackerError as error:
        return _print_error(error)
    except ParameterException as error:
        # Of rclpy's own parameters, such as use_sim_time; those of our tables raise ParameterError.
        return _print_error(ParameterError(one_line(error)))
    except ExternalShutdownException:
        pass  # The context was shut down from elsewhere; that is an orderly end.
    finally:
        executor.shutdown()
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown(context=context)
    return 0


def arguments_without_ros(arguments: Sequence[str] | None) -> list[str]:
    """Return the arguments that are not ROS arguments: a node accepts none."""
    given = list(arguments) if arguments is not None else sys.argv
    try:
        return [str(argument) for argument in remove_ros_args(given)[1:]]
    except RuntimeError:
        return []  # They cannot even be parsed, which is told when ROS starts.


def _print_error(error: CableTrackerError) -> int:
    print(f"error: {error}", file=sys.stderr)
    return EXIT_USER_ERROR


def _spin(node: ProcessNode, executor: SingleThreadedExecutor, stop: StopRequest) -> None:
    while node.context.ok() and not stop.requested and not node.finished:
        executor.spin_once(timeout_sec=min(max(node.seconds_until_due(), 0.0), WAKE_UP))
        node.work()
