"""The random numbers of a frame, drawn in a few calls: row by row those of each particle.

A particle finds its own in its row, whatever it is drawn from, so that the order in which particles
are drawn does not matter.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE
from cable_tracker.particle_filter.student_t import student_t_factors

BIRTH_TAIL = 4.0
"""Degrees of freedom of the Student-t of births about the remembered cable."""

STRIPS_ANYWHERE, STRIPS_ALIKE = 64, 96
"""Numbers of strips that measure a frame's background: of any kind, and like the hypotheses."""

ALIKE = 3
"""Number of perturbed components (alpha, log w, beta) of a strip like the hypothesis."""


class FrameNoise(NamedTuple):
    """Random numbers for N particles, B of which are births.

    Attributes
    ----------
    normal : FloatArray
        Standard normal, shape (N, 8): columns of the state.
    tail_factors : FloatArray
        Factors that make Student-t numbers of the normal ones, shape (N, 2): of the pose, of the
        rates.
    uniform : FloatArray
        Uniform in [0, 1), shape (N, 8): places of births in the search box. Column 0 of a particle
        whose pose is proposed chooses the ancestor that gives it its rates.
    about_memory : FloatArray
        Student-t, shape (B, 4): deviations of births from the remembered cable, in its scales.
    anywhere : FloatArray
        Uniform in [0, 1), shape (R, 4): d, alpha, w, beta of background strips of any kind.
    elsewhere : FloatArray
        Uniform in [0, 1), shape (S,): d of background strips like the hypotheses.
    alike : FloatArray
        Standard normal, shape (S, 3): deviations of alpha, log w, beta of background strips like
        the hypotheses.
    """

    normal: FloatArray
    tail_factors: FloatArray
    uniform: FloatArray
    about_memory: FloatArray
    anywhere: FloatArray
    elsewhere: FloatArray
    alike: FloatArray


def draw_frame_noise(
    rng: np.random.Generator, count: int, births: int, degrees_of_freedom: float
) -> FrameNoise:
    """Draw for `count` particles, `births` of which are born.

    `degrees_of_freedom` are those of the movement; with infinite ones they are 1.
    """
    normal = rng.standard_normal((count, STATE_SIZE))
    tail_factors = student_t_factors(rng, count, 2, degrees_of_freedom)
    return FrameNoise(
        normal,
        tail_factors,
        rng.random((count, STATE_SIZE)),
        rng.standard_t(BIRTH_TAIL, (births, POSE_SIZE)),
        rng.random((STRIPS_ANYWHERE, POSE_SIZE)),
        rng.random(STRIPS_ALIKE),
        rng.standard_normal((STRIPS_ALIKE, ALIKE)),
    )
