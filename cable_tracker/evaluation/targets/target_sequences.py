"""Sequences on which target trackers are judged: simulated scenarios, and recordings with boxes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

from cable_tracker.arrays import Image
from cable_tracker.errors import RecordingError
from cable_tracker.evaluation.evaluation_sequences import LabelledRecording
from cable_tracker.sequences.encodings import decode_bgr_levels
from cable_tracker.sequences.labels.target_labels import find_boxes
from cable_tracker.sequences.source import open_chosen
from cable_tracker.sequences.source_base import ChosenRecording
from cable_tracker.simulation.targets.sequence import simulate_target
from cable_tracker.target.model.estimate import Box


@dataclass(frozen=True, slots=True, eq=False)
class TargetEvaluationFrame:
    """A frame, decoded, with what is known about it.

    Attributes
    ----------
    image : Image
        uint8, or float32 in 0..255 of deeper recordings; blue-green-red, shape (H, W, 3).
    stamp : int
        Time of the frame [ns].
    truth : Box or None
        True box of the visible part of the target [px]; None while out of view, or unknown.
    twin : Box or None
        True box of a second target of the same appearance [px].
    is_judged : bool
        Whether claims of this frame count.
    """

    image: Image
    stamp: int
    truth: Box | None
    twin: Box | None = None
    is_judged: bool = True


class TargetSequence(Protocol):
    """Something to judge on. It is sent to other processes, and opened there."""

    @property
    def name(self) -> str:
        """Name of the sequence in reports."""
        ...

    def frame_count(self) -> int | None:
        """Return the number of frames; None if it is unknown before all have been read."""
        ...

    def files(self) -> list[Path]:
        """Return the files and folders that it is read from; none if it is made up."""
        ...

    def frames(self, seed: int) -> Iterator[TargetEvaluationFrame]:
        """Make or read the frames."""
        ...


@dataclass(frozen=True, slots=True)
class SimulatedTarget:
    """A scenario: a key of `TARGET_SCENARIOS`; each seed is another run.

    Attributes
    ----------
    name : str
        Name of the scenario.
    length : int
        Number of frames.
    """

    name: str
    length: int = 150

    def frame_count(self) -> int | None:
        """Return the number of frames."""
        return self.length

    def files(self) -> list[Path]:
        """Return no files."""
        return []

    def frames(self, seed: int) -> Iterator[TargetEvaluationFrame]:
        """Simulate the run of a seed."""
        for frame in simulate_target(self.name, seed, self.length):
            yield TargetEvaluationFrame(frame.image, frame.stamp, frame.box, frame.twin_box)


@dataclass(frozen=True, slots=True)
class RecordedTarget(LabelledRecording):
    """A recording of the user's with boxes, which `truth` holds."""

    def frame_count(self) -> int | None:
        """Return the number of frames, and see that there is something to judge.

        Raises
        ------
        RecordingError
            The recording or the boxes cannot be read, do not fit, or there are none.
        """
        with open_chosen(self._unlabelled()) as source:
            find_boxes(source, self.truth)
            return source.frame_count

    def frames(self, seed: int) -> Iterator[TargetEvaluationFrame]:
        """Read the recording.

        Raises
        ------
        RecordingError
            It is damaged, or shows the target in none of its frames.
        """
        shown = 0
        with open_chosen(self._unlabelled()) as source:
            truth = find_boxes(source, self.truth)
            for frame in source.frames():
                box = truth.box(frame)
                shown += box is not None
                is_judged = truth.knows(frame) or self.unlabelled_is_empty
                image = self.decoded(frame, decode_bgr_levels)
                if image is not None:
                    yield TargetEvaluationFrame(image, frame.stamp, box, is_judged=is_judged)
        if not shown:
            raise RecordingError(
                f"{self.path}: no frame has a box; label at least the one to start from"
            )

    def _unlabelled(self) -> ChosenRecording:
        """Return the recording without what would be taken for labels of a cable."""
        return replace(self, truth=None)
