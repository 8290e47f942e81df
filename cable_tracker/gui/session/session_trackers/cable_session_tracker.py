"""The tracker of a cable in a recording session."""

from __future__ import annotations

from dataclasses import replace

from cable_tracker.arrays import Image
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.detection.line_pairs import pair_limits
from cable_tracker.errors import ParameterError
from cable_tracker.gui.session.session import AnyStart
from cable_tracker.gui.session.session_trackers.session_tracker import SessionTracker
from cable_tracker.gui.session.snapshot import CableSnapshot
from cable_tracker.gui.subject.subject import CABLE
from cable_tracker.metric.recorded.recorded_cable import RecordedCableInstruments
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.offline.track_cable import given_state_for, row_of, track_picture
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import CompressedImage, Frame, RawImage
from cable_tracker.sequences.messages.cable import cloud_of
from cable_tracker.sequences.source_base import Source
from cable_tracker.sequences.tables.estimates import EstimateRow
from cable_tracker.trackers import CableTracker, make_tracker, warm_up
from cable_tracker.tracking.parameter_table import ParameterSet

UNTRACKED = Withheld(Reason.NOT_TRACKING, "this frame was not tracked")
"""Said in place of metres."""


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
            row=row_of(frame, estimate, ms, metres),
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
