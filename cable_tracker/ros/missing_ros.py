"""Error message where ROS is not installed, or does not fit this Python. Imports no ROS."""

from __future__ import annotations

from cable_tracker.errors import one_line

ROS_PARTS = ("rclpy", "_msgs", "std_srvs", "rosidl", "ament", "librcl", "librmw")
"""Parts of the names of its packages and libraries."""

ADVICE = "run `pip install '.[ros]'` in the package's folder, or source /opt/ros/jazzy/setup.bash"


def missing_ros_message(error: ImportError) -> str:
    """Say in one line that a part of ROS cannot be imported, and what to do.

    Empty where the error has another cause. rclpy names no module where it misses its own library.
    """
    missing = error.name or one_line(error)
    if not any(part in missing for part in ROS_PARTS):
        return ""
    return f"rclpy or a message package is not installed ({missing}); {ADVICE}"
