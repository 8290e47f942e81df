"""The labels of a recording while they are being edited, and interpolated between key frames."""

from __future__ import annotations

from bisect import bisect, bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from cable_tracker.cable.model.geometry import (
    Borders,
    project_borders,
    states_from_borders,
    states_in_chart,
    wrap_states,
)
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError
from cable_tracker.gui.labelling.labels import WITHOUT_CABLE, FrameLabel, Labels, Origin

Changes: TypeAlias = Mapping[int, FrameLabel | None]
"""New labels by the number of the frame; None takes the label away."""


def interpolated_states(
    before: CableState, after: CableState, shares: Sequence[float]
) -> list[CableState]:
    """Return the cable at places between two others, each border moving from one to the other.

    The second cable is written with its normal within a quarter turn of the first one's, so that
    the way between them never goes across the wrap of alpha.

    Parameters
    ----------
    shares : sequence of float
        Places between them, from 0 to 1.
    """
    both = np.stack((before.to_array(), after.to_array()))
    both[1:] = states_in_chart(both[1:], before.angle)
    borders = project_borders(both)
    # Written out: the last bit of a product of matrices depends on how many rows they have.
    on = np.array(shares)[:, None]
    angles, offsets = (
        (1.0 - on) * first + on * second for first, second in (borders.angles, borders.offsets)
    )
    states = np.zeros((len(on), both.shape[1]))
    states[:, :4] = states_from_borders(Borders(angles, offsets))
    return [CableState.from_array(state) for state in wrap_states(states)]


@dataclass(frozen=True, slots=True)
class Gap:
    """The frames between two key frames.

    Attributes
    ----------
    before, after : int
        Numbers of the two key frames.
    """

    before: int
    after: int

    @property
    def frames(self) -> range:
        """Numbers of the frames between."""
        return range(self.before + 1, self.after)


def gaps(labels: Labels) -> list[Gap]:
    """Return the gaps that can be filled: between key frames that both show a cable."""
    return [
        gap
        for gap in (Gap(before, after) for before, after in pairwise(_key_frames(labels)))
        if gap.frames and can_be_filled(labels, gap)
    ]


def gap_at(labels: Labels, frame: int) -> Gap | None:
    """Return the gap in which a frame lies, or that ends or begins at it; None if there is none."""
    touching = [gap for gap in gaps(labels) if gap.before <= frame <= gap.after]
    return touching[0] if touching else None


def stretches_at(labels: Labels, frames: Iterable[int]) -> list[Gap]:
    """Return the stretches between neighbouring key frames that contain or end at some frames.

    Before the first key frame and after the last a frame without a label stands for one.
    """
    ends = [min(labels, default=0) - 1, *_key_frames(labels), max(labels, default=0) + 1]
    places = {
        min(max(place - 1, 0), len(ends) - 2)
        for frame in frames
        for place in (bisect_left(ends, frame), bisect(ends, frame))
    }
    return [Gap(ends[place], ends[place + 1]) for place in sorted(places)]


def can_be_filled(labels: Labels, gap: Gap) -> bool:
    """Tell whether both ends of a gap show a cable."""
    ends = labels.get(gap.before, WITHOUT_CABLE), labels.get(gap.after, WITHOUT_CABLE)
    return all(label.state is not None for label in ends)


def interpolated_in(labels: Labels, gap: Gap) -> list[int]:
    """Return the frames of a gap whose labels are interpolated."""
    frames = gap.frames
    labelled = filter(labels.__contains__, frames) if len(frames) < len(labels) else labels
    return [frame for frame in labelled if frame in frames and not labels[frame].is_key]


def _key_frames(labels: Labels) -> list[int]:
    return sorted(frame for frame, label in labels.items() if label.is_key)


def filled_gap(labels: Labels, gap: Gap, stamps: Mapping[int, int]) -> dict[int, FrameLabel]:
    """Return labels for the frames of a gap, interpolated over time.

    Parameters
    ----------
    labels : Labels
        Labels with the key frames at both ends of the gap.
    gap : Gap
        Gap between labelled frames to interpolate.
    stamps : mapping
        Times of frames [ns]. Where one is missing, or time stands still, the frames count as
        equally far apart.
    """
    before, after = labels[gap.before].state, labels[gap.after].state
    assert before is not None and after is not None
    times = [stamps.get(frame) for frame in range(gap.before, gap.after + 1)]
    known = [time for time in times if time is not None]
    if len(known) < len(times) or any(late <= early for early, late in pairwise(known)):
        known = list(range(gap.before, gap.after + 1))
    span = known[-1] - known[0]
    shares = [(time - known[0]) / span for time in known[1:-1]]
    states = interpolated_states(before, after, shares)
    return {
        frame: FrameLabel(state, Origin.INTERPOLATED)
        for frame, state in zip(gap.frames, states, strict=True)
    }


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
