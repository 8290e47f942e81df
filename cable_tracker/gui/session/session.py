"""Session that the window watches and commands: a recording tracked here, or a live node."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import TypeAlias

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.gui.session.snapshot import AnySnapshot
from cable_tracker.gui.subject.subject import Subject
from cable_tracker.target.model.start import TargetStart
from cable_tracker.tracking.parameter_table import ParameterSpec, ParameterValue

AnyStart: TypeAlias = GivenState | TargetStart
"""Start given by the user: the place of a cable or of a target."""

Listener: TypeAlias = Callable[[AnySnapshot], None]
"""Told of every new snapshot, in the session's own thread: it must not take long."""


class Session(ABC):
    """Keeps the newest snapshot, hands each on to all that listen, and takes commands.

    Methods may be called from any thread, and may block.

    Attributes
    ----------
    name : str
        Name of the recording or node, for the title of the page.
    subject : Subject
        Description of the tracked object for the page.
    table : sequence of ParameterSpec
        The parameters that can be changed while it runs, in the order of docs/parameters.md.
    """

    name: str
    subject: Subject
    table: Sequence[ParameterSpec]

    def __init__(self) -> None:
        self._latest: AnySnapshot | None = None
        self._listeners: list[Listener] = []
        self._listening = threading.Lock()

    @property
    def latest(self) -> AnySnapshot | None:
        """The newest snapshot."""
        return self._latest

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Call a listener with every snapshot from now on; returns the function that ends it."""
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

    @property
    @abstractmethod
    def trouble(self) -> str:
        """Trouble that keeps frames from coming: damage, a node that is gone. Empty without any."""

    @property
    @abstractmethod
    def is_enabled(self) -> bool:
        """Whether the tracker takes frames."""

    @abstractmethod
    def parameters(self) -> Mapping[str, ParameterValue]:
        """Return the values in force, by name.

        Raises
        ------
        CableTrackerError
            They cannot be had.
        """

    @abstractmethod
    def change(self, values: Mapping[str, object]) -> None:
        """Change parameters, all of them or none.

        Raises
        ------
        ParameterError
            A value is refused; the message says why, and nothing has changed.
        RosError
            The node does not answer.
        """

    @abstractmethod
    def initialise(self, start: AnyStart) -> None:
        """Start the next frame from what the user says."""

    @abstractmethod
    def reset(self) -> None:
        """Forget everything."""

    @abstractmethod
    def enable(self, wanted: bool) -> None:
        """Let the tracker take frames, or not."""

    @abstractmethod
    def close(self) -> None:
        """End all threads and connections."""
