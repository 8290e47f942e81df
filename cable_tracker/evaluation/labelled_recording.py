"""A recording of the user's that methods are judged on."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

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

    def files(self) -> list[Path]:
        """Return what it is read from: a file or a folder, and the labels."""
        return [self.path] if self.truth is None else [self.path, self.truth]


def files_of(sequence: object) -> list[Path]:
    """Return the files that a sequence is read from; none of a simulated one."""
    return sequence.files() if isinstance(sequence, LabelledRecording) else []
