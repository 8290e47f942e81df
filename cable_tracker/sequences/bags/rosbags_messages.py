"""Messages as rosbags knows them, for bags written without ROS."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype

from cable_tracker.arrays import FloatArray
from cable_tracker.sequences.bags.typestores import typestore
from cable_tracker.sequences.messages.factory import Message


def _default_of_base(name: str) -> object:
    if name == "string":
        return ""
    if name == "bool":
        return False
    return 0.0 if name.startswith("float") else 0


def _default(definition: Any) -> object:  # noqa: ANN401
    # A definition is (kind, detail); the shape of the detail depends on the kind.
    kind, detail = definition
    if kind == Nodetype.BASE:
        return _default_of_base(detail[0])
    if kind == Nodetype.NAME:
        return RosbagsMessages().make(detail)
    element, count = detail
    if element[0] == Nodetype.BASE and element[1][0] != "string":
        dtype = {"octet": "uint8", "char": "uint8", "byte": "uint8"}.get(
            element[1][0], element[1][0]
        )
        return np.zeros(count if kind == Nodetype.ARRAY else 0, dtype=dtype)
    return [_default(element) for _ in range(count if kind == Nodetype.ARRAY else 0)]


class RosbagsMessages:
    """The `MessageFactory` of rosbags."""

    def make(self, type_name: str, /, **fields: object) -> Message:
        """Return a message; fields that are not given are zero or empty."""
        store = typestore()
        _, definitions = store.fielddefs[type_name]
        values: dict[str, Any] = {
            name: fields[name] if name in fields else _default(definition)
            for name, definition in definitions
        }
        return store.types[type_name](**values)

    def doubles(self, values: Sequence[float] | FloatArray) -> object:
        """Return the value of a field ``float64[]``."""
        return np.asarray(values, dtype=np.float64)

    def octets(self, data: bytes | memoryview) -> object:
        """Return the value of a field ``uint8[]``."""
        return np.frombuffer(data, dtype=np.uint8)

    def octet(self, value: int) -> object:
        """Return the value of a field ``byte``."""
        return value
