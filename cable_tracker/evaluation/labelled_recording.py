"""A recording of the user's that methods are judged on."""

from __future__ import annotations

from dataclasses import dataclass, field

from cable_tracker.sequences.source import ChosenRecording


@dataclass(frozen=True, slots=True)
class LabelledRecording(ChosenRecording):
    """A recording with labels, the same for every seed.

    Attributes
    ----------
    unlabelled_is_empty : bool
        Whether a frame without a label shows nothing to track. Otherwise it is not judged.
    """

    unlabelled_is_empty: bool = field(default=False, kw_only=True)

    @property
    def name(self) -> str:
        """The name of the file or folder."""
        return self.path.resolve().name
