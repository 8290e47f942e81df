"""The ROS part, imported only when it is asked for: everything else works without ROS."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from cable_tracker.errors import RosError
from cable_tracker.ros.missing_ros import missing_ros_message


def need_ros(name: str) -> ModuleType:
    """Return a module of `cable_tracker.ros`.

    Raises
    ------
    RosError
        ROS is not installed, or does not fit this Python.
    """
    try:
        return import_module(f"cable_tracker.ros.{name}")
    except ImportError as error:
        message = missing_ros_message(error)
        if not message:
            raise
        raise RosError(message) from error
