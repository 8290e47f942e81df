"""Proposed labels: the tracker's or a detector's estimate in a frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from cable_tracker.cable.model.geometry import wrap_state
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.detection.baselines.detectors import DETECTORS
from cable_tracker.detection.line_pairs import pair_limits
from cable_tracker.errors import FrameError
from cable_tracker.gui.labelling.labels import Labels
from cable_tracker.sequences.encodings import decode_grey
from cable_tracker.sequences.frame import Frame
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.trackers import make_tracker

MOST_FRAMES = 250
"""Largest number of frames from a label over which the tracker is sent; farther away a detector
looks at the frame instead."""

MOST_FRAMES_IN_DOUBT = 10
"""Number of frames from a label for which the particles are still about the cable, claimed or not:
over one frame of the simulated scenarios within 1 px where no cable was claimed."""

DETECTOR = "hough"


@dataclass(frozen=True, slots=True)
class LabelProposal:
    """Proposed label of one frame.

    Attributes
    ----------
    frame : int
        Number of the frame.
    state : CableState or None
        Proposed state of the cable [px, rad]; None if nothing was found.
    message : str
        How it was found, or why it was not.
    """

    frame: int
    state: CableState | None
    message: str


class Proposer:
    """Proposes labels. The same labels and frames give the same proposal.

    Parameters
    ----------
    read : callable
        Returns a frame by its number; see `FrameAccess.frame`.
    """

    def __init__(self, read: Callable[[int], Frame], parameters: TrackerParameters) -> None:
        self._read = read
        self._parameters = parameters
        self._detector = DETECTORS[DETECTOR](pair_limits(parameters))

    def propose(
        self, frame: int, labels: Labels, stopped: Callable[[], bool] = lambda: False
    ) -> LabelProposal:
        """Propose a label.

        The tracker starts at the last labelled frame before, if a cable is labelled there and it is
        not too far back. Otherwise a detector looks at this frame alone, and the tracker at the
        place that it names.

        Parameters
        ----------
        frame : int
            Number of the frame.
        stopped : callable
            Tells whether the answer is no longer wanted.

        Raises
        ------
        IndexError, RecordingError
            There is no such frame.
        """
        if stopped():
            return LabelProposal(frame, None, "stopped")
        start = max((number for number in labels if number < frame), default=None)
        if start is not None and frame - start <= MOST_FRAMES and labels[start].state is not None:
            return self._track(start, frame, labels, stopped)
        return self._detect(frame)

    def _track(
        self, start: int, frame: int, labels: Labels, stopped: Callable[[], bool]
    ) -> LabelProposal:
        tracker = make_tracker(self._parameters)
        tracker.initialise(GivenState.around(self._moving_state(start, labels)))
        estimate = None
        for number in range(start, frame + 1):
            if stopped():
                return LabelProposal(frame, None, "stopped")
            try:
                frame_read = self._read(number)
                estimate = tracker.process(decode_grey(frame_read.image), frame_read.stamp)
            except FrameError as error:
                estimate = None
                if number == frame:
                    return LabelProposal(frame, None, str(error))
        message = f"tracked from frame {start}"
        if estimate is not None and estimate.is_claimed:
            return LabelProposal(frame, estimate.state.at_rest(), message)
        if estimate is not None and frame - start <= MOST_FRAMES_IN_DOUBT:
            return LabelProposal(frame, estimate.state.at_rest(), f"{message}, in doubt")
        return LabelProposal(frame, None, f"the tracker has lost the cable since frame {start}")

    def _moving_state(self, start: int, labels: Labels) -> CableState:
        """Return the state of a label, with the rates that the label one frame before implies."""
        state, before = labels[start].state, labels.get(start - 1)
        assert state is not None
        if before is None or before.state is None:
            return state
        seconds = (self._read(start).stamp - self._read(start - 1).stamp) / NANOSECONDS
        if seconds <= 0.0:
            return state
        now = state.to_array()
        then = wrap_state(before.state.to_array(), state.angle)
        rates = (now - then)[:2] / seconds
        return replace(state, distance_rate=float(rates[0]), angle_rate=float(rates[1]))

    def _detect(self, frame: int) -> LabelProposal:
        picture = self._read(frame)
        try:
            grey = decode_grey(picture.image)
            found = self._detector.detect(grey)
        except FrameError as error:
            return LabelProposal(frame, None, str(error))
        if not found:
            return LabelProposal(frame, None, "no cable was detected")
        tracker = make_tracker(self._parameters)
        tracker.initialise(GivenState.around(found[0].state, is_guess=True))
        estimate = tracker.process(grey, picture.stamp)
        if not estimate.is_claimed:
            state = found[0].state.at_rest()
            return LabelProposal(frame, state, "detected in this frame, in doubt")
        return LabelProposal(frame, estimate.state.at_rest(), "detected in this frame")
