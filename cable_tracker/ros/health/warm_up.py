"""Compiles what a tracker needs before frames come, beside the node's own work."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Hashable

_WARM: set[Hashable] = set()
"""Variants that this process has run already."""


class WarmUp:
    """Runs a tracker of its own on a few frames, in a thread.

    The node can answer services, publish its diagnostics and be stopped meanwhile. The thread is a
    daemon: the process can end without waiting for the compiler.

    Parameters
    ----------
    variant : hashable
        Which code is compiled; a variant that has run in this process runs no more.
    run : callable
        Runs every line of that code once.
    """

    def __init__(self, variant: Hashable, run: Callable[[], None]) -> None:
        self._variant = variant
        self._work = run
        self._begin = time.monotonic()
        self._error: Exception | None = None
        self._thread: threading.Thread | None = None
        if self._variant not in _WARM:
            self._thread = threading.Thread(target=self._run, name="warm-up", daemon=True)
            self._thread.start()

    def _run(self) -> None:
        try:
            self._work()
            _WARM.add(self._variant)
        except Exception as error:  # noqa: BLE001  Raised again in the node's own thread.
            self._error = error

    @property
    def running(self) -> bool:
        """Whether it still compiles."""
        return self._thread is not None and self._thread.is_alive()

    @property
    def seconds(self) -> float:
        """Time since it began [s]."""
        return time.monotonic() - self._begin

    def finish(self) -> None:
        """Wait for the end, and raise what was raised in the thread."""
        if self._thread is not None:
            self._thread.join()
        if self._error is not None:
            raise self._error
