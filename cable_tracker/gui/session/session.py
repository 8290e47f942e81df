"""Session that the window watches and commands, and the snapshots that it hands on.

A session is a recording tracked here, or a live node; a snapshot holds the results of a tracker for
one frame.
"""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.gui.subject import Subject
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.withheld import Withheld
from cable_tracker.offline.target_table import TargetRow
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.target.model.estimate import Box
from cable_tracker.target.model.start import TargetStart
from cable_tracker.tracking.parameter_table import ParameterSpec, ParameterValue

Row = TypeVar("Row", EstimateRow, TargetRow)

AnyStart: TypeAlias = GivenState | TargetStart
"""Start given by the user: the place of a cable or of a target."""


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot(Generic[Row]):
    """Results of a filter for one frame, whatever it tracks.

    Attributes
    ----------
    number : int
        Counts the snapshots of a session; each has a larger one than those before.
    frame : int or None
        Number of the frame in its recording; None of a live camera.
    image : Image
        The frame, uint8: grey, shape (H, W), of a target also blue-green-red, shape (H, W, 3).
    row : EstimateRow or TargetRow
        The frame's row of the table; of a live camera its frame is the number of the snapshot. The
        status may also be another one of diagnostics: DISABLED, WARMING UP, ...
    """

    number: int
    frame: int | None
    image: Image
    row: Row


@dataclass(frozen=True, slots=True, eq=False)
class CableSnapshot(Snapshot[EstimateRow]):
    """Results of the filter of a cable for one frame.

    Attributes
    ----------
    rate_sigma : tuple of float
        Standard deviations of the rates [per second]; empty where they are not known.
    cloud : FloatArray or None
        Particles and their weights, shape (N, 9): columns of `CableState`, then the weight. None
        if there are none.
    hypotheses : tuple of Hypothesis
        Hypotheses, as `CableEstimate` has them; empty if they are not known.
    truth : CableState or None
        True state of the cable, if the frame is labelled.
    metres : CrossTrack, Withheld or None
        The cable beside the vehicle, or why it is not known there; None where there are no
        instruments.
    """

    rate_sigma: tuple[float, ...] = ()
    cloud: FloatArray | None = None
    hypotheses: tuple[Hypothesis, ...] = ()
    truth: CableState | None = None
    metres: CrossTrack | Withheld | None = None


@dataclass(frozen=True, slots=True, eq=False)
class TargetSnapshot(Snapshot[TargetRow]):
    """Results of the filter of a target for one frame.

    Attributes
    ----------
    outline : FloatArray
        Corners of the contour, from the top left corner [px], shape (K, 2).
    cloud : FloatArray or None
        Particles, columns of `TargetClaim.state`, and their weights, shape (N, 7); None if there
        are none.
    score : float or None
        Score of the fit of the estimated region.
    truth : Box or None
        True box of the target [px], if the frame is labelled.
    """

    outline: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    cloud: FloatArray | None = None
    score: float | None = None
    truth: Box | None = None


AnySnapshot: TypeAlias = CableSnapshot | TargetSnapshot

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
