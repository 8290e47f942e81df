"""Which recording to open, and how."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cable_tracker.cable.initial_state_text import RANDOM
from cable_tracker.sequences.source import Source, open_source


@dataclass(frozen=True, slots=True)
class RecordingRequest:
    """What the user says about a recording.

    Attributes
    ----------
    path, topic, rate, truth, skip_bad_frames, allow_outside
        See `open_source`.
    init : str
        Where to start: `random`, `truth`, the name of a detector, or `d,alpha,w,beta` [px, rad].
    """

    path: Path
    topic: str | None = None
    rate: float | None = None
    truth: Path | None = None
    skip_bad_frames: bool = False
    allow_outside: bool = False
    init: str = RANDOM

    def open(self) -> Source:
        """Open it.

        Raises
        ------
        RecordingError
            It is missing, empty, damaged, or of no known kind.
        ParameterError
            The rate is not a positive number.
        """
        return open_source(
            self.path,
            topic=self.topic,
            rate=self.rate,
            truth=self.truth,
            skip_bad_frames=self.skip_bad_frames,
            allow_outside=self.allow_outside,
        )
