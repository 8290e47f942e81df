"""How long a rig waits for its nodes."""

from __future__ import annotations

import time

SILENCE_TIMEOUT = 90.0
"""After so long without a frame a run is given up [s]."""


class SilenceWatch:
    """Measures for how long nothing has come."""

    def __init__(self) -> None:
        self._heard = time.monotonic()

    def hear(self) -> None:
        """Take note that something has come now."""
        self._heard = time.monotonic()

    def complaint(self) -> str:
        """Say that nothing has come for too long; empty while it is not too long."""
        if time.monotonic() - self._heard <= SILENCE_TIMEOUT:
            return ""
        return f"nothing came for {SILENCE_TIMEOUT:g} s; is the machine too busy? run it again"
