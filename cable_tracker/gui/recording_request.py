"""Which recording to open, and where to start in it."""

from __future__ import annotations

from dataclasses import dataclass

from cable_tracker.cable.model.initial_state_text import RANDOM
from cable_tracker.sequences.source import ChosenRecording


@dataclass(frozen=True, slots=True)
class RecordingRequest(ChosenRecording):
    """What the user says about a recording.

    Attributes
    ----------
    init : str
        Where to start: `random`, `truth`, the name of a detector, or `d,alpha,w,beta` [px, rad].
    """

    init: str = RANDOM
