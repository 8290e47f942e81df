"""Session that the window watches and commands: a recording tracked here, or a live node."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, TypeAlias

from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.gui.session.snapshot import AnySnapshot
from cable_tracker.gui.subject.subject import Subject
from cable_tracker.target.model.start import TargetStart
from cable_tracker.tracking.parameter_table import ParameterSpec, ParameterValue

AnyStart: TypeAlias = GivenState | TargetStart
"""Start given by the user: the place of a cable or of a target."""

Listener: TypeAlias = Callable[[AnySnapshot], None]
"""Told of every new snapshot, in the session's own thread: it must not take long."""


class Session(Protocol):
    """Interface of all sessions. Methods may be called from any thread, and may block.

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

    @property
    def latest(self) -> AnySnapshot | None:
        """The newest snapshot."""
        ...

    @property
    def trouble(self) -> str:
        """Trouble that keeps frames from coming: damage, a node that is gone. Empty without any."""
        ...

    @property
    def is_enabled(self) -> bool:
        """Whether the tracker takes frames."""
        ...

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Tell a listener of every snapshot from now on; returns the function that ends it."""
        ...

    def parameters(self) -> Mapping[str, ParameterValue]:
        """Return the values in force, by name.

        Raises
        ------
        CableTrackerError
            They cannot be had.
        """
        ...

    def change(self, values: Mapping[str, object]) -> None:
        """Change parameters, all of them or none.

        Raises
        ------
        ParameterError
            A value is refused; the message says why, and nothing has changed.
        RosError
            The node does not answer.
        """
        ...

    def initialise(self, start: AnyStart) -> None:
        """Start the next frame from what the user says."""
        ...

    def reset(self) -> None:
        """Forget everything."""
        ...

    def enable(self, wanted: bool) -> None:
        """Let the tracker take frames, or not."""
        ...

    def close(self) -> None:
        """End all threads and connections."""
        ...
