"""The search region of a detector, around an expected cable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.cable.model.geometry import states_in_chart
from cable_tracker.cable.model.state import ANGLE, DISTANCE, WIDTH, CableState


@dataclass(frozen=True, slots=True)
class SearchRegion:
    """A box of cables around an expected one.

    Attributes
    ----------
    state : CableState
        The expected cable [px, rad].
    distance : float
        Largest difference of d [px].
    angle : float
        Largest difference of alpha [rad].
    width : float
        Largest difference of w [px].
    """

    state: CableState
    distance: float
    angle: float
    width: float

    def scaled(self, factor: float) -> SearchRegion:
        """Return the region for an image enlarged by a factor."""
        return SearchRegion(
            state=self.state.scaled(factor),
            distance=self.distance * factor,
            angle=self.angle,
            width=self.width * factor,
        )

    def admits(self, states: FloatArray) -> BoolArray:
        """Return which cables (N, 8) lie in the box, also across the wrap, shape (N,)."""
        expected = self.state
        chart = states_in_chart(states, expected.angle)
        inside: BoolArray = (
            (np.abs(chart[:, DISTANCE] - expected.distance) <= self.distance)
            & (np.abs(chart[:, ANGLE] - expected.angle) <= self.angle)
            & (np.abs(chart[:, WIDTH] - expected.width) <= self.width)
        )
        return inside

    def covers(self, points: FloatArray) -> BoolArray:
        """Return which points some border of a cable in the box may pass through.

        Parameters
        ----------
        points : FloatArray
            x, y in the image frame [px], shape (..., 2).
        """
        expected = self.state
        cos, sin = np.cos(expected.angle), np.sin(expected.angle)
        across = points[..., 0] * cos + points[..., 1] * sin - expected.distance
        along = points[..., 1] * cos - points[..., 0] * sin
        turn = min(self.angle + abs(expected.skew), np.deg2rad(80.0))
        reach = (expected.width + self.width) / 2 + self.distance + np.abs(along) * np.tan(turn)
        covered: BoolArray = np.abs(across) <= reach
        return covered
