from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from cable_tracker.sequences.bags.rosbags_messages import typestore


@pytest.fixture
def sent() -> Callable[[Any], Any]:
    """Write a message as CDR and read it again: return it as it arrives."""

    def send(message: Any) -> Any:
        kind = message.__msgtype__
        return typestore().deserialize_cdr(typestore().serialize_cdr(message, kind), kind)

    return send
