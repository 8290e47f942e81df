"""At the border of the picture: the Markov chain of section 6.6, (35) to (37)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.target.model.state import X, Y

RATE = 20.0
"""l of (35); the thesis gives no value. In the middle of the picture P_b is l exp(-l): with 3 it
would be 0.15, and a target there would be taken for one at the border within a few frames."""

LOST_FRAMES = 3
"""Consecutive frames without a contour worth evolving after which the target is outside."""

RETURN = 0.02
"""(37): both rows are (.02, .98)."""

BORDER_SHARE = 0.1
"""Width of the area at the border, as a share of the picture; our choice."""

GROWTH = 0.01
"""Growth per frame of the interval about the point of exit, as a share of the picture's side."""


def transitions(distance: float) -> tuple[float, float]:
    """Return P_b and P_g of (35), clipped to [0, 1].

    Parameters
    ----------
    distance : float
        To the nearest border, 0 at it and 1 in the middle.
    """
    to_border = RATE * math.exp(-RATE * distance)
    to_generic = RATE * math.exp(-RATE * (1.0 - distance))
    return min(to_border, 1.0), min(to_generic, 1.0)


@dataclass(frozen=True, slots=True)
class BorderModel:
    """State of the chain. Immutable.

    Attributes
    ----------
    at_border : bool
        Whether the model for the border is in force, not the generic one.
    unseen : int
        Frames without a contour worth evolving.
    x, y : float
        Place of the target when last seen, from the image centre, y up [px].
    """

    at_border: bool = False
    unseen: int = 0
    x: float = 0.0
    y: float = 0.0

    @property
    def is_outside(self) -> bool:
        """Whether the target has left."""
        return self.at_border and self.unseen >= LOST_FRAMES

    def after(
        self, state: FloatArray, shape: tuple[int, int], is_seen: bool, rng: np.random.Generator
    ) -> BorderModel:
        """Return the model after a frame whose best particle is `state`."""
        if not is_seen:
            return replace(self, unseen=self.unseen + 1)
        x, y = float(state[X]), float(state[Y])
        to_border, to_generic = transitions(_distance(x, y, shape))
        if self.is_outside:
            to_border, to_generic = 1.0 - RETURN, RETURN
        chance = float(rng.random())
        at_border = chance >= to_generic if self.at_border else chance < to_border
        return BorderModel(at_border, 0, x, y)

    def placed(
        self, states: FloatArray, shape: tuple[int, int], rng: np.random.Generator
    ) -> FloatArray:
        """Return the places of the particles: along the border's line where that is the model.

        Disappearing, uniform along the near border; appearing, along the line where the area of the
        border begins; outside, about the point of exit in an interval that grows.
        """
        if not self.at_border:
            return states
        height, width = shape
        placed = states.copy()
        inset = 0.0 if not self.is_outside else BORDER_SHARE
        reach = min(GROWTH * max(self.unseen, 1), 0.5)
        spread = rng.uniform(-1.0, 1.0, len(states))
        if width / 2 - abs(self.x) < height / 2 - abs(self.y):
            placed[:, X] = math.copysign((0.5 - inset) * width, self.x)
            placed[:, Y] = self.y + spread * (reach * height if self.is_outside else height / 8)
        else:
            placed[:, Y] = math.copysign((0.5 - inset) * height, self.y)
            placed[:, X] = self.x + spread * (reach * width if self.is_outside else width / 8)
        return placed


def _distance(x: float, y: float, shape: tuple[int, int]) -> float:
    height, width = shape
    return min(max(min(1.0 - 2.0 * abs(x) / width, 1.0 - 2.0 * abs(y) / height), 0.0), 1.0)
