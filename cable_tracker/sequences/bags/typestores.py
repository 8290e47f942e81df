"""The message definitions of rosbags, loaded once."""

from __future__ import annotations

from functools import cache

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore


@cache
def typestore() -> Typestore:
    """Return the messages of ROS 2 Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)


@cache
def ros1_typestore() -> Typestore:
    """Return the messages of ROS 1 Noetic."""
    return get_typestore(Stores.ROS1_NOETIC)


def add_definition(name: str, text: str) -> None:
    """Teach the store of ROS 2 a message type that is not one of ROS' own."""
    store = typestore()
    if name not in store.fielddefs:
        store.register(get_types_from_msg(text, name))
