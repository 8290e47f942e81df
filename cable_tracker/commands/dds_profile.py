"""`cable-tracker dds-profile`."""

from __future__ import annotations

from cable_tracker.resources import DDS_PROFILE, resource


def dds_profile() -> None:
    """Print where the Fast DDS profile for nodes on one machine lies."""
    print(resource(DDS_PROFILE))
