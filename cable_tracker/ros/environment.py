"""The environment in which our processes find each other, and nobody else."""

from __future__ import annotations

import os

from cable_tracker.resources import DDS_PROFILE, resource

PROFILE_VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"
RANGE_VARIABLE = "ROS_AUTOMATIC_DISCOVERY_RANGE"


def local_environment() -> dict[str, str]:
    """Return this process' environment with ROS traffic kept on this machine.

    The shipped Fast DDS profile binds to loopback alone, gives large frames room and lets processes
    find each other quickly. With it the discovery range is left to the profile: LOCALHOST would
    open further sockets on all interfaces. What the user has set stays.

    Raises
    ------
    ResourceError
        The profile is not where it should be. Fast DDS itself would go on without it and say
        little.
    """
    environment = dict(os.environ)
    if PROFILE_VARIABLE in environment:
        environment.setdefault(RANGE_VARIABLE, "LOCALHOST")
        return environment
    environment[PROFILE_VARIABLE] = str(resource(DDS_PROFILE))
    environment.setdefault(RANGE_VARIABLE, "SYSTEM_DEFAULT")
    return environment


def use_local_environment() -> None:
    """Set this process' own environment so; to be called before rclpy is initialised."""
    os.environ.update(local_environment())
