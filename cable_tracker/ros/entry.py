"""What the executables `tracker` and `replay` start."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Sequence
from typing import NoReturn

from cable_tracker.errors import EXIT_USER_ERROR
from cable_tracker.ros.stop_request import stop_on_signals

MISSING_ROS = (
    "error: rclpy or a message package is not installed ({name}); run"
    " `pip install '.[ros]'` in the package's folder, or source /opt/ros/jazzy/setup.bash"
)
USAGE = (
    "usage: {node} --ros-args [-p NAME:=VALUE]... [--params-file FILE] [-r FROM:=TO]...\n"
    "docs/parameters.md lists the parameters. Everything must stand behind --ros-args."
)
ROS_PACKAGES = ("rclpy", "_msgs", "std_srvs", "rosidl", "ament")


def _run(node_name: str, arguments: Sequence[str] | None) -> int:
    # Before the imports: they take a while, and a signal may come any time.
    stop = stop_on_signals()
    try:
        from cable_tracker.ros.process import (  # noqa: PLC0415
            arguments_without_ros,
            run_node,
        )
        from cable_tracker.ros.replay_node import ReplayNode  # noqa: PLC0415
        from cable_tracker.ros.tracker_node import TrackerNode  # noqa: PLC0415
    except ModuleNotFoundError as error:
        if not any(part in str(error.name) for part in ROS_PACKAGES):
            raise
        print(MISSING_ROS.format(name=error.name), file=sys.stderr)
        return EXIT_USER_ERROR
    strangers = arguments_without_ros(arguments)
    if strangers:
        print(USAGE.format(node=node_name), file=sys.stderr)
        return 0 if strangers[0] in ("-h", "--help") else EXIT_USER_ERROR
    node_class = {"tracker": TrackerNode, "replay": ReplayNode}[node_name]
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


def tracker() -> None:
    """Run the tracker node until it is stopped."""
    _end(_run("tracker", None))


def replay() -> None:
    """Run the replay node until the recording is at its end."""
    _end(_run("replay", None))


if __name__ == "__main__":
    # `python -m cable_tracker.ros.entry tracker --ros-args ...`, where no script is on the path.
    _end(_run(sys.argv[1], sys.argv[1:]))
