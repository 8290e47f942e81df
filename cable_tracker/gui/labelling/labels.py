"""Labels by a person of one frame: the place of the cable, or that there is none."""

from __future__ import annotations

import math
from bisect import bisect, bisect_left
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
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
)
from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import ParameterError
from cable_tracker.sequences.sequence_file import wrapped_if_outside

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
    """

    state: CableState | None
    origin: Origin = Origin.HAND

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

WITHOUT_CABLE = FrameLabel(None)
"""The label of a frame that shows no cable."""


def flagged_label(state: CableState | None, flag: str) -> FrameLabel:
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
    return WITHOUT_CABLE if state is None else FrameLabel(state, Origin(flag))


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
        raise ParameterError(f"w must be from {SMALLEST_WIDTH:g} px up, not {width:g}")
    if abs(skew) > LARGEST_SKEW:
        limit, given = math.degrees(LARGEST_SKEW), math.degrees(skew)
        raise ParameterError(f"beta must be within ±{limit:g} deg, not {given:g}")
    if abs(distance) > LARGEST_LENGTH:
        raise ParameterError(f"d must be within ±{LARGEST_LENGTH:g} px, not {distance:g}")
    # Wrapping rounds; what was typed must stay as it is.
    return wrapped_if_outside(CableState(*numbers))


def interpolated_state(before: CableState, after: CableState, fraction: float) -> CableState:
    """Return the cable between two others, each border moving from one to the other.

    The second cable is written with its normal within a quarter turn of the first one's, so that
    the way between them never goes across the wrap of alpha.

    Parameters
    ----------
    fraction : float
        Place between them, from 0 to 1.
    """
    both = np.stack((before.to_array(), after.to_array()))
    both[1:] = states_in_chart(both[1:], before.angle)
    borders = project_borders(both)
    share = np.array([1.0 - fraction, fraction])
    between = Borders(share @ borders.angles, share @ borders.offsets)
    states = np.zeros((1, both.shape[1]))
    states[:, :4] = states_from_borders(Borders(between.angles[None], between.offsets[None]))
    return CableState.from_array(wrap_states(states)[0])


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
    keys = sorted(frame for frame, label in labels.items() if label.is_key)
    return [
        Gap(before, after)
        for before, after in pairwise(keys)
        if after > before + 1
        and labels[before].state is not None
        and labels[after].state is not None
    ]


def gap_at(labels: Labels, frame: int) -> Gap | None:
    """Return the gap in which a frame lies, or that ends or begins at it; None if there is none."""
    touching = [gap for gap in gaps(labels) if gap.before <= frame <= gap.after]
    return touching[0] if touching else None


def stranded(labels: Labels, changed: Iterable[int]) -> list[int]:
    """Return the interpolated frames that lie in no gap, of those beside changed frames.

    Parameters
    ----------
    changed : iterable of int
        Numbers of the frames whose labels were changed; only frames between the key frames beside
        them are looked at.
    """
    keys = sorted(frame for frame, label in labels.items() if label.is_key)
    ordered = sorted(changed)
    found = []
    for frame, label in labels.items():
        if label.is_key:
            continue
        place = bisect(keys, frame)
        first = keys[place - 1] if place > 0 else -math.inf
        last = keys[place] if place < len(keys) else math.inf
        is_beside = bisect_left(ordered, first) < bisect(ordered, last)
        ends = [labels[end].state for end in (first, last) if isinstance(end, int)]
        if is_beside and (len(ends) < 2 or None in ends):
            found.append(frame)
    return found


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
    return {
        frame: FrameLabel(
            interpolated_state(before, after, (time - known[0]) / span), Origin.INTERPOLATED
        )
        for frame, time in zip(gap.frames, known[1:-1], strict=True)
    }
