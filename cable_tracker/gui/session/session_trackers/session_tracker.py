"""Trackers as a recording session uses them: frame in, snapshot out, whatever is followed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Self

from cable_tracker.arrays import Image
from cable_tracker.gui.session.session import AnyStart
from cable_tracker.gui.session.snapshot import AnySnapshot
from cable_tracker.gui.subject.subject import Subject
from cable_tracker.metric.recorded.recorded_instruments import RecordedInstruments
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences.frame import CompressedImage, Frame, RawImage
from cable_tracker.sequences.pictures.shown_levels import shown_levels, stand_in
from cable_tracker.target.tracker import TargetTracker
from cable_tracker.trackers import CableTracker
from cable_tracker.tracking.parameter_table import ParameterSet, ParameterValue


class SessionTracker(ABC):
    """A tracker, and what a session wants to know of it.

    Parameters
    ----------
    parameters : ParameterSet
        Parameters of the tracker.
    tracker : CableTracker or TargetTracker
        Tracker with these parameters.
    instruments : RecordedInstruments or None
        The recording's instruments; None: it has none.

    Attributes
    ----------
    subject : Subject
        Description of the tracked object for the page.
    trouble : str
        Why this run did not start as was asked; empty if it did.
    """

    subject: Subject
    trouble: str = ""
    _tracker: CableTracker | TargetTracker
    _parameters: ParameterSet
    _instruments: RecordedInstruments[Any] | None

    def __init__(
        self,
        parameters: ParameterSet,
        tracker: CableTracker | TargetTracker,
        instruments: RecordedInstruments[Any] | None,
    ) -> None:
        self._parameters, self._tracker, self._instruments = parameters, tracker, instruments
        self._forget_picture()

    @property
    def particles(self) -> Particles | None:
        """The present belief."""
        return self._tracker.particles

    def parameters(self) -> Mapping[str, ParameterValue]:
        """Return the values in force, by name."""
        return self._parameters.as_mapping()

    @abstractmethod
    def warm_up(self) -> None:
        """Compile and load what frames will need."""

    def begin(self) -> None:
        """Be ready for the first frame of the recording, with the start that was asked for."""
        self._begin_tracker()
        if self._instruments is not None:
            self._instruments.jump(to_start=True)

    @abstractmethod
    def _begin_tracker(self) -> None:
        """Initialise the tracker with the start that was asked for."""

    def reset(self) -> None:
        """Forget everything."""
        self._tracker.reset()
        self.trouble = ""
        if self._instruments is not None:
            self._instruments.jump()

    def copy(self) -> Self:
        """Return a copy that continues as this one would, without the frame's picture."""
        other = self.__new__(type(self))
        other.__dict__ = self.__dict__ | {"_tracker": self._tracker.copy()}
        if self._instruments is not None:
            other._instruments = self._instruments.copy()
        other._forget_picture()
        return other

    def _forget_picture(self) -> None:
        """Let go of the picture of the last frame; the next one brings its own."""
        self._decoded = self._shown = stand_in()

    @abstractmethod
    def initialise(self, start: AnyStart) -> None:
        """Start the next frame from what the user says.

        Raises
        ------
        FrameError
            It cannot be; nothing has changed.
        """

    def configure(self, values: Mapping[str, object]) -> bool:
        """Change parameters, all or none; tell whether any has another value now.

        Raises
        ------
        ParameterError
            A value is refused.
        """
        parameters = self._parameters.replaced(values)
        if parameters == self._parameters:
            return False
        self._configure_tracker(parameters)
        self._parameters = parameters
        return True

    def close(self) -> None:
        """Read no more of the recording."""
        if self._instruments is not None:
            self._instruments.close()

    @abstractmethod
    def _configure_tracker(self, parameters: ParameterSet) -> None:
        """Let the tracker go on with other parameters."""

    def decode(self, frame: Frame) -> None:
        """Decode a frame, which is shown from now on.

        Raises
        ------
        FrameError
            It cannot be decoded.
        """
        # Of one that cannot be decoded, the picture before is not shown under its number.
        height, width = self._decoded.shape[:2]
        self._shown = stand_in((width, height))
        self._decoded = self._decode(frame.image)
        self._shown = shown_levels(self._decoded)

    @abstractmethod
    def _decode(self, image: RawImage | CompressedImage) -> Image:
        """Return a picture as the tracker takes it, or raise a FrameError."""

    @abstractmethod
    def follow(self, frame: Frame, number: int) -> AnySnapshot:
        """Track the frame that was decoded last; return its snapshot with a number.

        Raises
        ------
        FrameError
            It cannot be used.
        """

    @abstractmethod
    def show(self, frame: Frame, number: int, status: str, reason: str = "") -> AnySnapshot:
        """Return a snapshot of a frame that is not tracked."""
