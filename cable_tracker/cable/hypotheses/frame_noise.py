"""The random numbers of a frame, drawn in a few calls: row by row those of each particle.

A particle finds its own in its row, whatever it is drawn from, so that the order in which particles
are drawn does not matter.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE
from cable_tracker.particle_filter.student_t import student_t_stretches

BIRTH_TAIL = 4.0
"""Degrees of freedom of the Student-t about where the cable was."""

STRIPS_ANYWHERE, STRIPS_ALIKE = 64, 96
"""Strips that the hypotheses of a frame are held against: of any kind, and like them."""

ALIKE = 3
"""They are alike in alpha, w, beta."""


class FrameNoise(NamedTuple):
    """Random numbers for N particles, B of which are births.

    Attributes
    ----------
    normal : FloatArray
        Standard normal, shape (N, 8): columns of the state.
    stretches : FloatArray
        Factors that give them heavy tails, shape (N, 2): for the pose, for the rates.
    uniform : FloatArray
        From 0 to 1, shape (N, 8): where in the search box. For a particle whose pose is proposed,
        column 0 says which ancestor gives it its rates.
    about_memory : FloatArray
        Student-t, shape (B, 4): how far from where the cable was last seen.
    anywhere : FloatArray
        From 0 to 1, shape (R, 4): strips of any kind that hypotheses are held against.
    elsewhere : FloatArray
        From 0 to 1, shape (S,): where the strips lie that are like the hypotheses.
    alike : FloatArray
        Standard normal, shape (S, 3): how like them they are.
    """

    normal: FloatArray
    stretches: FloatArray
    uniform: FloatArray
    about_memory: FloatArray
    anywhere: FloatArray
    elsewhere: FloatArray
    alike: FloatArray


def draw_frame_noise(
    rng: np.random.Generator, count: int, births: int, degrees_of_freedom: float
) -> FrameNoise:
    """Draw for `count` particles, `births` of which are born.

    `degrees_of_freedom` are those of the movement; infinite ones stretch nothing.
    """
    normal = rng.standard_normal((count, STATE_SIZE))
    stretches = student_t_stretches(rng, count, 2, degrees_of_freedom)
    return FrameNoise(
        normal,
        stretches,
        rng.random((count, STATE_SIZE)),
        rng.standard_t(BIRTH_TAIL, (births, POSE_SIZE)),
        rng.random((STRIPS_ANYWHERE, POSE_SIZE)),
        rng.random(STRIPS_ALIKE),
        rng.standard_normal((STRIPS_ALIKE, ALIKE)),
    )
