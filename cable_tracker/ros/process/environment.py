"""The environment in which our processes find each other, and no other ones."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree

from cable_tracker.errors import ResourceError
from cable_tracker.resources import DDS_PROFILE, resource

PROFILE_VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"
NEWER_PROFILE_VARIABLE = "FASTDDS_DEFAULT_PROFILES_FILE"
MIDDLEWARE_VARIABLE = "RMW_IMPLEMENTATION"
FAST_DDS = "fastrtps"
RANGE_VARIABLE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
DOMAIN_VARIABLE = "ROS_DOMAIN_ID"


def local_environment() -> dict[str, str]:
    """Return this process' environment with ROS traffic kept on this machine.

    The shipped Fast DDS profile binds to loopback alone, gives large frames room and lets processes
    find each other quickly. With it the discovery range is left to the profile: LOCALHOST would
    open further sockets on all interfaces. What the user has set stays.

    Raises
    ------
    ResourceError
        The profile is not where it should be, or the user's is not; see `check_profile`.
    """
    check_profile()
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


def check_profile() -> None:
    """Check that the Fast DDS profile that the environment names can be read.

    Fast DDS itself prints a line about it and goes on with its defaults: other sockets, other
    buffers, and nodes that do not find each other.

    Raises
    ------
    ResourceError
        The file is missing or no XML.
    """
    if FAST_DDS not in os.environ.get(MIDDLEWARE_VARIABLE, FAST_DDS):
        return
    for variable in (PROFILE_VARIABLE, NEWER_PROFILE_VARIABLE):
        if os.environ.get(variable):
            _check_profile_file(variable, Path(os.environ[variable]))


def _check_profile_file(variable: str, path: Path) -> None:
    advice = f"correct {variable} or unset it; `cable-tracker dds-profile` names the one that ships"
    try:
        ElementTree.parse(path)
    except OSError as error:
        raise ResourceError(f"the Fast DDS profile {path} cannot be read; {advice}") from error
    except ElementTree.ParseError as error:
        raise ResourceError(f"the Fast DDS profile {path} is no XML ({error}); {advice}") from error
