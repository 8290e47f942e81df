"""The message definitions of rosbags, loaded once."""

from __future__ import annotations

from functools import cache

from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore


@cache
def typestore() -> Typestore:
    """Return the messages of ROS 2 Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)


@cache
def ros1_typestore() -> Typestore:
    """Return the messages of ROS 1 Noetic."""
    return get_typestore(Stores.ROS1_NOETIC)
