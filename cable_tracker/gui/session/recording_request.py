"""Which recording to open, and where to start in it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

from cable_tracker.cable.model.initial_state_text import RANDOM
from cable_tracker.sequences.bags.instruments import InstrumentChoice
from cable_tracker.sequences.source_base import ChosenRecording


@dataclass(frozen=True, slots=True)
class RecordingRequest(ChosenRecording):
    """Choices of the user about a recording.

    Attributes
    ----------
    init : str
        Initialisation: `random`, `truth`, a detector's name, or `d,alpha,w,beta` [px, rad].
    choice : InstrumentChoice
        Topics of the instruments.
    vehicle : Path or None
        The user's `vehicle.yaml`; None: the one in the bag's folder, if there is one.
    """

    init: str = RANDOM
    choice: InstrumentChoice = field(default_factory=InstrumentChoice)
    vehicle: Path | None = None

    def for_other(self, path: Path) -> RecordingRequest:
        """Return the request for another recording, opened like this one.

        Topics that were named and the vehicle file are those of the recording that was named with
        them, or of the first one that is opened if none was.
        """
        if self.path in (path, Path()):
            return replace(self, path=path)
        return replace(self, path=path, choice=InstrumentChoice(), vehicle=None)
