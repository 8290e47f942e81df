"""Trackers as a recording session uses them: frame in, snapshot out, of a cable or of a target."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Self

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.detection.line_pairs import pair_limits
from cable_tracker.errors import ParameterError
from cable_tracker.gui.session.session import AnySnapshot, AnyStart, CableSnapshot, TargetSnapshot
from cable_tracker.gui.subject import CABLE, TARGET, Subject
from cable_tracker.metric.recorded_instruments import RecordedCableInstruments, RecordedInstruments
from cable_tracker.metric.targets.target_instrument_fusion import TargetInstrumentFusion
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.offline import target_table, track_cable
from cable_tracker.offline.target_table import TargetRow
from cable_tracker.offline.track_cable import given_state_for, track_picture
from cable_tracker.offline.track_target import follow_picture
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences.encodings import decode_bgr_levels, decode_grey
from cable_tracker.sequences.frame import CompressedImage, Frame, RawImage
from cable_tracker.sequences.labels.target_labels import BoxTruth
from cable_tracker.sequences.messages.cable import cloud_of
from cable_tracker.sequences.pictures.shown_levels import shown_levels, stand_in
from cable_tracker.sequences.source_base import Source
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.target.model.start import StartText, TargetStart, parse_start_text
from cable_tracker.target.model.state import LOG_SCALE
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import TargetTracker, warm_up_target
from cable_tracker.trackers import CableTracker, make_tracker, warm_up
from cable_tracker.tracking.parameter_table import ParameterSet, ParameterValue

UNTRACKED = Withheld(Reason.NOT_TRACKING, "this frame was not tracked")
"""Said in place of metres."""


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


class CableSessionTracker(SessionTracker):
    """Follows a cable.

    Parameters
    ----------
    init : str
        Initialisation: `random`, `truth`, a detector's name, or `d,alpha,w,beta` [px, rad].
    instruments : RecordedCableInstruments or None
        The recording's instruments; None: everything stays in pixels.

    Raises
    ------
    ParameterError
        There is no such start, or the response table cannot be read.
    """

    subject = CABLE
    _tracker: CableTracker
    _parameters: TrackerParameters
    _instruments: RecordedCableInstruments | None

    def __init__(
        self,
        source: Source,
        init: str,
        parameters: TrackerParameters,
        instruments: RecordedCableInstruments | None,
    ) -> None:
        self._source, self._init = source, init
        self._limits = pair_limits(parameters)
        self._start = given_state_for(source, init, self._limits)
        self._no_start = ""
        super().__init__(parameters, make_tracker(parameters), instruments)

    def warm_up(self) -> None:
        """Compile and load what frames will need."""
        warm_up(self._parameters)

    def _begin_tracker(self) -> None:
        self._update_start()
        self.trouble = self._no_start
        if self._start is not None:
            self._tracker.initialise(self._start)

    def _update_start(self) -> None:
        """Find the start anew where other cables may be followed than when it was found."""
        limits = pair_limits(self._parameters)
        if limits == self._limits:
            return
        self._start, self._no_start = None, ""
        try:
            self._start = given_state_for(self._source, self._init, limits)
        except ParameterError as error:
            # The user watches: the recording goes on as from `random`.
            self._no_start = str(error)
        self._limits = limits

    def initialise(self, start: AnyStart) -> None:
        """Start the next frame from a belief."""
        assert isinstance(start, GivenState), "a cable is not marked with an outline"
        self._tracker.initialise(start)
        self.trouble = ""

    def _configure_tracker(self, parameters: ParameterSet) -> None:
        assert isinstance(parameters, TrackerParameters)
        self._tracker.configure(parameters)

    def _decode(self, image: RawImage | CompressedImage) -> Image:
        return decode_grey(image)

    def follow(self, frame: Frame, number: int) -> CableSnapshot:
        """Track a frame."""
        estimate, ms, metres = track_picture(frame, self._decoded, self._tracker, self._instruments)
        particles = self._tracker.particles
        return replace(
            self.show(frame, number, estimate.status.value),
            row=track_cable.row_of(frame, estimate, ms, metres),
            rate_sigma=tuple(estimate.standard_deviations()[4:].tolist()),
            cloud=cloud_of(particles) if particles is not None else None,
            hypotheses=estimate.hypotheses,
            metres=metres,
        )

    def show(self, frame: Frame, number: int, status: str, reason: str = "") -> CableSnapshot:
        """Return a snapshot of a frame that is not tracked."""
        return CableSnapshot(
            number=number,
            frame=frame.index,
            image=self._shown,
            row=EstimateRow(frame.index, frame.stamp, status, event=reason),
            truth=frame.truth,
            metres=None if self._instruments is None else UNTRACKED,
        )


class TargetSessionTracker(SessionTracker):
    """Follows a target.

    Parameters
    ----------
    init : str
        Initialisation: `wait` for a mark, `detect`, or `x0,y0,x1,y1` [px].
    truth : BoxTruth
        True boxes of the labelled frames [px].
    instruments : RecordedInstruments or None
        The recording's instruments, which tell how the camera turned; None: it has none.

    Raises
    ------
    ParameterError
        There is no such start.
    """

    subject = TARGET
    _tracker: TargetTracker
    _parameters: TargetParameters
    _instruments: RecordedInstruments[TargetInstrumentFusion] | None

    def __init__(
        self,
        init: str,
        parameters: TargetParameters,
        truth: BoxTruth,
        instruments: RecordedInstruments[TargetInstrumentFusion] | None,
    ) -> None:
        self._truth = truth
        self._start: StartText = parse_start_text(init)
        if len(self._start.boxes) > 1:
            raise ParameterError("init: the window follows one target; mark only one")
        super().__init__(parameters, TargetTracker(self._with_detector(parameters)), instruments)

    def warm_up(self) -> None:
        """Compile and load what frames will need."""
        warm_up_target(self._with_detector(self._parameters))

    def _with_detector(self, parameters: TargetParameters) -> TargetParameters:
        """Return parameters with a detector where the start needs one; the user's stay as given."""
        return parameters.with_detector() if self._start.detects else parameters

    def _begin_tracker(self) -> None:
        for start in self._start.boxes:
            self._tracker.initialise(start)

    def initialise(self, start: AnyStart) -> None:
        """Follow what is marked in the next frame."""
        assert isinstance(start, TargetStart), "a target is marked with a box or an outline"
        height, width = self._decoded.shape[:2]
        start.check((width, height))
        self._tracker.initialise(start)

    def _configure_tracker(self, parameters: ParameterSet) -> None:
        assert isinstance(parameters, TargetParameters)
        self._tracker.configure(self._with_detector(parameters))

    def _decode(self, image: RawImage | CompressedImage) -> Image:
        return decode_bgr_levels(image)

    def follow(self, frame: Frame, number: int) -> TargetSnapshot:
        """Track a frame."""
        estimate, ms, _ = follow_picture(frame, self._decoded, self._tracker, self._instruments)
        return replace(
            self.show(frame, number, estimate.status.value),
            row=target_table.row_of(frame, estimate, ms),
            outline=estimate.outline if estimate.is_claimed else np.empty((0, 2)),
            cloud=_poses_of(self._tracker.particles),
            score=float(estimate.score),
        )

    def show(self, frame: Frame, number: int, status: str, reason: str = "") -> TargetSnapshot:
        """Return a snapshot of a frame that is not tracked."""
        return TargetSnapshot(
            number=number,
            frame=frame.index,
            image=self._shown,
            row=TargetRow(frame.index, frame.stamp, status, event=reason),
            truth=self._truth.box(frame),
        )


def _poses_of(particles: Particles | None) -> FloatArray | None:
    """Return the columns of `TargetClaim.state` and the weight of each particle, (N, 7)."""
    if particles is None:
        return None
    cloud = np.column_stack((particles.states, particles.weights))
    cloud[:, LOG_SCALE] = np.exp(cloud[:, LOG_SCALE])
    return cloud
