"""Compiles what a tracker needs before frames come, beside the node's own work."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Hashable
from functools import cache
from queue import SimpleQueue

_WARM: set[Hashable] = set()
"""Variants that this process has run already."""


class WarmUp:
    """Runs a tracker of its own on a few frames, in a thread.

    The node can answer services, publish its diagnostics and be stopped meanwhile. All warm-ups of
    a process run one after the other in one thread: each thread would keep a network of its own,
    and an arena of memory. The thread is a daemon: the process can end without waiting for the
    compiler.

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
        self._abandoned = False
        self._ended = threading.Event()
        if self._variant in _WARM:
            self._ended.set()
        else:
            _waiting().put(self)

    def run(self) -> None:
        """Run that code unless it has run meanwhile; called by the thread of the warm-ups."""
        try:
            if not self._abandoned and self._variant not in _WARM:
                self._work()
                _WARM.add(self._variant)
        except Exception as error:  # noqa: BLE001  Raised again in the node's own thread.
            self._error = error
        finally:
            self._ended.set()

    @property
    def running(self) -> bool:
        """Whether it still compiles, or waits for its turn."""
        return not self._ended.is_set()

    @property
    def seconds(self) -> float:
        """Time since it began [s]."""
        return time.monotonic() - self._begin

    def abandon(self) -> None:
        """Cancel the warm-up unless it is running: the variant is not needed any more."""
        self._abandoned = True

    def finish(self) -> None:
        """Wait for the end, and raise what was raised in the thread."""
        self._ended.wait()
        if self._error is not None:
            raise self._error


@cache
def _waiting() -> SimpleQueue[WarmUp]:
    """Return the warm-ups that wait; the thread that runs them starts with the first."""
    queue: SimpleQueue[WarmUp] = SimpleQueue()
    threading.Thread(target=_run_all, args=(queue,), name="warm-up", daemon=True).start()
    return queue


def _run_all(queue: SimpleQueue[WarmUp]) -> None:
    while True:
        queue.get().run()
