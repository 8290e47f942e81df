"""The random numbers of a frame, drawn in a few calls: row by row those of each particle.

A particle finds its own in its row, whatever it is drawn from. So the order in which particles are
drawn does not matter, and both twins of the filter use the same ones.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.leaving import TAIL
from cable_tracker.cable.model.state import PLACES, STATE_SIZE


class FrameNoise(NamedTuple):
    """Random numbers for N particles, B of which are births.

    Attributes
    ----------
    normal : FloatArray
        Standard normal, shape (N, 8): columns of the state.
    stretches : FloatArray
        Factors that give them heavy tails, shape (N, 2): for the places, for the rates.
    uniform : FloatArray
        From 0 to 1, shape (N, 8): where in the search box. For a particle whose place is proposed,
        column 0 says which ancestor gives it its rates.
    about_memory : FloatArray
        Student-t, shape (B, 4): how far from where the cable was last seen.
    """

    normal: FloatArray
    stretches: FloatArray
    uniform: FloatArray
    about_memory: FloatArray

    def of_places(self, rows: slice) -> FloatArray:
        """Return Student-t noise of unit scale for d, alpha, w, beta, shape (n, 4)."""
        noise: FloatArray = self.normal[rows, :PLACES] * self.stretches[rows, :1]
        return noise

    def of_rates(self, rows: slice) -> FloatArray:
        """Return Student-t noise of unit scale for the rates, shape (n, 4)."""
        noise: FloatArray = self.normal[rows, PLACES:] * self.stretches[rows, 1:]
        return noise


def draw_frame_noise(
    rng: np.random.Generator, count: int, births: int, degrees_of_freedom: float
) -> FrameNoise:
    """Draw for `count` particles, `births` of which are born.

    `degrees_of_freedom` are those of the movement; infinite ones stretch nothing.
    """
    normal = rng.standard_normal((count, STATE_SIZE))
    if math.isinf(degrees_of_freedom):
        stretches = np.ones((count, 2))
    else:
        stretches = np.sqrt(degrees_of_freedom / rng.chisquare(degrees_of_freedom, (count, 2)))
    return FrameNoise(
        normal,
        stretches,
        rng.random((count, STATE_SIZE)),
        rng.standard_t(TAIL, (births, PLACES)),
    )
