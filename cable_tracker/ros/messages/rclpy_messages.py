"""Messages as rclpy knows them."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.sequences.messages.factory import Message


@cache
def message_class(type_name: str) -> type[Any]:
    """Return the class of a message type such as ``std_msgs/msg/Header``."""
    package, kind, name = type_name.split("/")
    message_type: type[Any] = getattr(import_module(f"{package}.{kind}"), name)
    return message_type


class RclpyMessages:
    """The `MessageFactory` of rclpy."""

    def make(self, type_name: str, /, **fields: object) -> Message:
        """Return a message; fields that are not given are zero or empty."""
        return message_class(type_name)(**fields)

    def doubles(self, values: Sequence[float] | FloatArray) -> object:
        """Return the value of a field ``float64[]``."""
        return array("d", np.asarray(values, dtype=np.float64).tobytes())

    def octets(self, data: bytes | memoryview) -> object:
        """Return the value of a field ``uint8[]``.

        An `array` filled at once: assigning anything else makes rclpy check each byte in Python.
        """
        octets = array("B")
        octets.frombytes(data)
        return octets

    def octet(self, value: int) -> object:
        """Return the value of a field ``byte``."""
        return bytes([value])


MESSAGES = RclpyMessages()
"""It has no state: one is enough."""
