"""Entry points of the executables: trackers, replay, simulator, controller."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Sequence
from functools import partial
from importlib import import_module
from typing import NoReturn

from cable_tracker.errors import EXIT_USER_ERROR
from cable_tracker.ros.missing_ros import missing_ros_message
from cable_tracker.ros.process.stop_request import stop_on_signals

USAGE = (
    "usage: {node} --ros-args [-p NAME:=VALUE]... [--params-file FILE] [-r FROM:=TO]...\n"
    "docs/parameters.md lists the parameters. Everything must stand behind --ros-args."
)
NODES = {
    "tracker": ("nodes.tracker_node", "TrackerNode"),
    "target_tracker": ("nodes.target_tracker_node", "TargetTrackerNode"),
    "baseline": ("rigs.baseline_node", "BaselineNode"),
    "replay": ("nodes.replay_node", "ReplayNode"),
    "simulator": ("nodes.simulator_node", "SimulatorNode"),
    "target_simulator": ("nodes.target_simulator_node", "TargetSimulatorNode"),
    "follower": ("nodes.follower_node", "FollowerNode"),
    "controller": ("nodes.controller_node", "ControllerNode"),
}
"""Module and class of each."""


def run(node_name: str, arguments: Sequence[str] | None) -> int:
    """Run a node until it ends or is stopped, and return the exit code.

    `arguments` are those of the process, its name first; None takes them from the command line.
    """
    # Before the imports: they take a while, and a signal may come any time.
    stop = stop_on_signals()
    try:
        from cable_tracker.ros.process.process_node import (  # noqa: PLC0415
            arguments_without_ros,
            run_node,
        )

        module_name, class_name = NODES[node_name]
        node_class = getattr(import_module(f"cable_tracker.ros.{module_name}"), class_name)
    except ImportError as error:
        message = missing_ros_message(error)
        if not message:
            raise
        print(f"error: {message}", file=sys.stderr)
        return EXIT_USER_ERROR
    strangers = arguments_without_ros(arguments)
    if strangers:
        print(USAGE.format(node=node_name), file=sys.stderr)
        return 0 if strangers[0] in ("-h", "--help") else EXIT_USER_ERROR
    return run_node(lambda context: node_class(context=context), arguments, stop)


def _end(code: int) -> NoReturn:
    """End this process, also where a thread of ours is in the middle of the compiler.

    The interpreter's own end would pull away from under that thread what it works with.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    if any(thread.daemon for thread in threading.enumerate()):
        os._exit(code)
    sys.exit(code)


def _run_to_end(node_name: str) -> NoReturn:
    """Run a node until its work is done or it is stopped, and end this process."""
    _end(run(node_name, None))


tracker = partial(_run_to_end, "tracker")
target_tracker = partial(_run_to_end, "target_tracker")
replay = partial(_run_to_end, "replay")
simulator = partial(_run_to_end, "simulator")
target_simulator = partial(_run_to_end, "target_simulator")
follower = partial(_run_to_end, "follower")
controller = partial(_run_to_end, "controller")


if __name__ == "__main__":
    # `python -m cable_tracker.ros.entry tracker --ros-args ...`, where no script is on the path.
    _end(run(sys.argv[1], sys.argv[1:]))
