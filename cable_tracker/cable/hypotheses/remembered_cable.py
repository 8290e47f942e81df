"""Where a cable was when it was last tracked, and how far from there it is looked for."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import inset
from cable_tracker.cable.model.state import POSE_SIZE, StateColumn, pose_units
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH, TrackerParameters

SPREAD = np.array([4.0, math.radians(2.0), 3.0, math.radians(1.0)])
"""Scales of the search about the last place, at first: d, alpha, w, beta [px at the reference
width, rad]."""

SPREADING = np.array([100.0, math.radians(37.0), 50.0, math.radians(7.5)])
"""Growth of these scales per second [px/s at the reference width, rad/s]."""

WIDEST = np.array([120.0, math.radians(60.0), 40.0, math.radians(10.0)])
"""Largest spread about the last place; a cable farther away is found by the uninformed search."""

LEFT_MARGIN = 3.0
"""A cable was leaving if it was nearer to the edge than this many `leaving_margin`."""


@dataclass(frozen=True, slots=True, eq=False)
class RememberedCable:
    """Where a cable was when it was last tracked.

    Attributes
    ----------
    pose : FloatArray
        d, alpha, w, beta, shape (4,) [px, rad].
    side : float
        Sign of d if it was leaving the image there; 0 if it was not.
    seconds : float
        Time since the cable was last tracked [s].
    """

    pose: FloatArray
    side: float
    seconds: float = 0.0

    def aged(self, dt: float) -> RememberedCable:
        """Return the same memory `dt` seconds later."""
        return RememberedCable(self.pose, self.side, self.seconds + dt)

    def scales(self, image_width: int) -> FloatArray:
        """Return how far from there the cable is looked for, shape (4,) [px, rad]."""
        scales = np.minimum(SPREAD + SPREADING * self.seconds, WIDEST)
        scaled: FloatArray = scales * pose_units(image_width)
        return scaled


def remember(
    state: FloatArray, image_size: tuple[int, int], parameters: TrackerParameters
) -> RememberedCable:
    """Return the memory of a cable, shape (8,), that is tracked now."""
    margin = LEFT_MARGIN * parameters.leaving_margin * image_size[0] / REFERENCE_WIDTH
    leaving = inset(state, image_size) < margin
    side = float(np.sign(state[StateColumn.DISTANCE])) if leaving else 0.0
    return RememberedCable(state[:POSE_SIZE].copy(), side)
