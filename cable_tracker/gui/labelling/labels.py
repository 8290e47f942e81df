"""Labels by a person of one frame: the place of the cable, or that there is none."""

from __future__ import annotations

import math
from bisect import bisect, bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from cable_tracker.cable.model.geometry import (
    Borders,
    project_borders,
    states_from_borders,
    states_in_chart,
    wrap_states,
    wrapped_cable,
)
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError

NO_CABLE = "no_cable"

SMALLEST_WIDTH = 1.0
"""w of a label that is drawn [px]."""

LARGEST_SKEW = math.radians(45.0)
"""|beta| of a label that is drawn [rad]."""

LARGEST_LENGTH = 1e5
"""|d| and w of a label that is drawn [px]."""


class Origin(str, Enum):
    """Origin of a label's state."""

    HAND = "hand"
    """A person has drawn or corrected it."""

    PROPOSED = "proposed"
    """The tracker has proposed it, and a person has accepted it as it was."""

    INTERPOLATED = "interpolated"
    """Label between two key frames that a person has not looked at."""


@dataclass(frozen=True, slots=True)
class FrameLabel:
    """The label of one frame.

    Attributes
    ----------
    state : CableState or None
        d, alpha, w, beta [px, rad], the rates zero; None: no cable is in view.
    origin : Origin
        Origin of the state.
    stamp : int or None
        Time that the frame had when it was labelled, as it stands in a file [ns]; None: it is
        labelled here, at the time that it has now.
    """

    state: CableState | None
    origin: Origin = Origin.HAND
    stamp: int | None = field(default=None, compare=False)

    @property
    def is_key(self) -> bool:
        """Whether a person has seen it; other frames are interpolated between such frames."""
        return self.origin is not Origin.INTERPOLATED

    @property
    def flag(self) -> str:
        """The word for it in the file of flags."""
        return NO_CABLE if self.state is None else self.origin.value


Labels: TypeAlias = Mapping[int, FrameLabel]
"""Labels by the number of the frame. A frame that is not in it is not labelled."""


def stamps_of(labels: Labels) -> dict[int, int]:
    """Return the times of those labels that have one [ns]."""
    return {frame: label.stamp for frame, label in labels.items() if label.stamp is not None}


WITHOUT_CABLE = FrameLabel(None)
"""The label of a frame that shows no cable."""


def flagged_label(state: CableState | None, flag: str, stamp: int | None = None) -> FrameLabel:
    """Return the label that a flag stands for.

    Raises
    ------
    ValueError
        There is no such flag, or it does not go with the state.
    """
    if (flag == NO_CABLE) != (state is None):
        raise ValueError(
            f"the flag {flag!r} does not go with {'no' if state is None else 'a'} cable"
        )
    return FrameLabel(state, Origin.HAND if state is None else Origin(flag), stamp)


def state_from_page(values: Iterable[object]) -> CableState:
    """Return the state for d, alpha, w, beta that came from a browser.

    Parameters
    ----------
    values : iterable
        Four numbers [px, rad]; the angle may have any number of turns.

    Raises
    ------
    ParameterError
        They are no four numbers, or such a cable cannot be drawn.
    """
    numbers = [
        float(value)
        for value in values
        if isinstance(value, (int, float)) and not isinstance(value, bool)
    ]
    if len(numbers) != 4 or not all(map(math.isfinite, numbers)):
        raise ParameterError("a label needs four finite numbers d, alpha, w, beta; draw it again")
    distance, _, width, skew = numbers
    if not SMALLEST_WIDTH <= width <= LARGEST_LENGTH:
        raise ParameterError(
            f"w must be from {SMALLEST_WIDTH:g} to {LARGEST_LENGTH:g} px, not {width:g}"
        )
    if abs(skew) > LARGEST_SKEW:
        limit, given = math.degrees(LARGEST_SKEW), math.degrees(skew)
        raise ParameterError(f"beta must be within ±{limit:g} deg, not {given:g}")
    if abs(distance) > LARGEST_LENGTH:
        raise ParameterError(f"d must be within ±{LARGEST_LENGTH:g} px, not {distance:g}")
    # Wrapping rounds; what was typed must stay as it is.
    return wrapped_cable(CableState(*numbers))


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
