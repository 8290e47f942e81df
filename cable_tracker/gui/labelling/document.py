"""The labels of a recording while they are being edited."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from cable_tracker.errors import ParameterError
from cable_tracker.gui.labelling.labels import (
    FrameLabel,
    Gap,
    Labels,
    can_be_filled,
    filled_gap,
    gap_at,
    gaps,
    interpolated_in,
    stretches_at,
)

Changes: TypeAlias = Mapping[int, FrameLabel | None]
"""New labels by the number of the frame; None takes the label away."""


@dataclass(frozen=True, slots=True)
class _Step:
    """One undoable change of the labels.

    Attributes
    ----------
    frame : int
        Frame at which the user was.
    before, after : mapping
        Labels of the changed frames.
    """

    frame: int
    before: Changes
    after: Changes


class LabelDocument:
    """Labels by frame, with a memory of all edits. Knows no file and no window.

    Interpolated labels follow their key frames: a key frame that is moved, set or taken away
    changes the interpolated labels beside it too, in the same step. Those that lie between no two
    key frames with a cable any more are taken away with it.

    Parameters
    ----------
    times : mapping
        Times of frames [ns], as far as they are known; more may become known.
    """

    def __init__(self, labels: Labels, times: Mapping[int, int]) -> None:
        self._labels: dict[int, FrameLabel] = dict(labels)
        self.times = times
        self._undone: list[_Step] = []
        self._done: list[_Step] = []

    @property
    def labels(self) -> Labels:
        """The labels as they are now."""
        return MappingProxyType(self._labels)

    @property
    def can_undo(self) -> bool:
        """Whether there is an edit to take back."""
        return bool(self._done)

    @property
    def can_redo(self) -> bool:
        """Whether there is an edit to do again."""
        return bool(self._undone)

    def change(self, frame: int, changes: Changes, *, merges: bool = False) -> Changes:
        """Change labels, as one step.

        Parameters
        ----------
        frame : int
            Current frame; undo leads back to it.
        merges : bool
            Whether this goes on with the step before, for instance while a key is held down. Undo
            takes both back at once.

        Returns
        -------
        Changes
            All that is different now, with the interpolated labels beside.
        """
        step = self._apply(frame, changes)
        if not step.after:
            return step.after
        last = self._done[-1] if self._done else None
        if (
            merges
            and last is not None
            and last.frame == frame
            and set(step.after) == set(last.after)
        ):
            self._done[-1] = _Step(frame, last.before, step.after)
        else:
            self._done.append(step)
        self._undone.clear()
        return step.after

    def gaps_to_fill(self, frame: int | None) -> list[Gap]:
        """Return the gap at a frame, or all gaps.

        Raises
        ------
        ParameterError
            There is none.
        """
        if frame is None:
            found = gaps(self._labels)
        else:
            gap = gap_at(self._labels, frame)
            found = [gap] if gap is not None else []
        if not found:
            raise ParameterError(
                "nothing to interpolate here; label a frame before and one after, with a cable in"
                " both"
            )
        return found

    def interpolate(self, frame: int, wanted: list[Gap]) -> Changes:
        """Fill gaps between key frames; see `change`."""
        changes: dict[int, FrameLabel | None] = {}
        for gap in wanted:
            changes.update(filled_gap(self._labels, gap, self.times))
        return self.change(frame, changes)

    def replace(self, labels: Labels, frame: int = 0) -> Changes:
        """Put other labels in the place of all; see `change`."""
        step = self._write(frame, {**dict.fromkeys(self._labels), **labels})
        if step.after:
            self._done.append(step)
            self._undone.clear()
        return step.after

    def undo(self) -> tuple[int, Changes] | None:
        """Take the last step back.

        Returns
        -------
        int, Changes
            Where the user was, and what is different now; None if there is no step.
        """
        if not self._done:
            return None
        step = self._done.pop()
        self._undone.append(step)
        self._write(step.frame, step.before)
        return step.frame, step.before

    def redo(self) -> tuple[int, Changes] | None:
        """Do again what was taken back; see `undo`."""
        if not self._undone:
            return None
        step = self._undone.pop()
        self._done.append(step)
        self._write(step.frame, step.after)
        return step.frame, step.after

    def _apply(self, frame: int, changes: Changes) -> _Step:
        """Write changes, and let the interpolated labels beside follow."""
        first = self._write(frame, changes)
        followers: dict[int, FrameLabel | None] = {}
        for gap in stretches_at(self._labels, changes):
            between = [n for n in interpolated_in(self._labels, gap) if n not in changes]
            if between and can_be_filled(self._labels, gap):
                filled = filled_gap(self._labels, gap, self.times)
                followers.update(
                    (number, filled[number])
                    for number in between
                    if filled[number] != self._labels[number]
                )
            else:
                followers.update(dict.fromkeys(between))
        second = self._write(frame, followers)
        before = {**second.before, **first.before}
        return _Step(frame, before, {changed: self._labels.get(changed) for changed in before})

    def _write(self, frame: int, changes: Changes) -> _Step:
        before: dict[int, FrameLabel | None] = {}
        after: dict[int, FrameLabel | None] = {}
        for changed, label in changes.items():
            old = self._labels.get(changed)
            if old == label:
                if label is not None:
                    # It may be of another time.
                    self._labels[changed] = label
                continue
            before[changed], after[changed] = old, label
            if label is None:
                del self._labels[changed]
            else:
                self._labels[changed] = label
        return _Step(frame, before, after)
