"""How long a rig waits for its nodes, and how it knows that nothing more comes."""

from __future__ import annotations

import time

SILENCE_TIMEOUT = 300.0
"""Time without a frame, or before the first, after which a run is given up [s]."""

QUIET_TURNS = 50
"""Number of turns of the executor without a message after which its queues are empty.

A turn runs one callback. What else is ready, diagnostics or a service, takes turns with the
messages of the run, so that a few turns would do.
"""


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


class QuietWatch:
    """Counts the executor's turns since the last message of a run.

    That a process has ended says that its messages have arrived, not that they have been taken:
    they wait in the executor's queues. Turns tell, on a busy machine, too; time does not.
    """

    def __init__(self) -> None:
        self._heard = 0
        self._turns = 0

    def turn(self, heard: int) -> None:
        """Take note of a turn.

        Parameters
        ----------
        heard : int
            Number of messages received so far in the run.
        """
        self._turns = self._turns + 1 if heard == self._heard else 0
        self._heard = heard

    @property
    def is_quiet(self) -> bool:
        """Whether nothing is left in the queues."""
        return self._turns >= QUIET_TURNS
