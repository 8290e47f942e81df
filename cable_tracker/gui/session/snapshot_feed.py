"""Hands the snapshots of a session on to all that listen."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress

from cable_tracker.gui.session.session import Listener
from cable_tracker.gui.session.snapshot import AnySnapshot


class SnapshotFeed:
    """Keeps a session's newest snapshot, and notifies listeners of each."""

    def __init__(self) -> None:
        self._latest: AnySnapshot | None = None
        self._listeners: list[Listener] = []
        self._listening = threading.Lock()

    @property
    def latest(self) -> AnySnapshot | None:
        """The newest snapshot."""
        return self._latest

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Tell a listener of every snapshot from now on; returns the function that ends it."""
        with self._listening:
            self._listeners.append(listener)

        def end() -> None:
            with self._listening, suppress(ValueError):
                self._listeners.remove(listener)

        return end

    def _publish(self, snapshot: AnySnapshot) -> None:
        self._latest = snapshot
        with self._listening:
            listeners = tuple(self._listeners)
        for listener in listeners:
            listener(snapshot)
