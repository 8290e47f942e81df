"""The ROS part, imported only when it is asked for: everything else works without ROS."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from cable_tracker.errors import RosError


def need_ros(name: str) -> ModuleType:
    """Return a module of `cable_tracker.ros`.

    Raises
    ------
    RosError
        ROS is not installed.
    """
    try:
        return import_module(f"cable_tracker.ros.{name}")
    except ModuleNotFoundError as error:
        raise RosError(
            f"ROS 2 is not installed (no module {error.name}); run"
            " `pip install '.[ros]'` in the package's folder, or source /opt/ros/jazzy/setup.bash"
        ) from error
