"""`cable-tracker dds-profile`."""

from __future__ import annotations

from cable_tracker.resources import DDS_PROFILE, resource


def dds_profile() -> None:
    """Print the path of the Fast DDS profile for one machine."""
    print(resource(DDS_PROFILE))
