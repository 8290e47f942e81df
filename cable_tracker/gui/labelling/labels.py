"""Labels by a person of one frame: the place of the cable, or that there is none."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import TypeAlias

from cable_tracker.cable.model.geometry import (
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
