"""Where a target that was not in view comes into it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.particle_filter.student_t import log_densities, standard_student_t
from cable_tracker.target.model.state import PLACES, POSE_SIZE, PoseColumn
from cable_tracker.tracking.survival import share_about_last_place

TAIL = 4.0
"""Degrees of freedom about the last place."""

FIRST_SPREAD, SPREADING, WIDEST = 0.1, 0.35, 0.5
"""How far from the last place at once, how much farther every second, and at most: in widths."""

SCALE_SPREAD, SCALE_SPREADING, WIDEST_SCALE = 0.25, 0.15, 0.6
"""The same of the log scale."""

ANGLE_SPREAD, ANGLE_SPREADING, WIDEST_ANGLE = 0.15, 0.3, 0.8
"""The same of the angle [rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class Births:
    """Density of the poses of a target that appears.

    Attributes
    ----------
    last : FloatArray
        Pose when it was last in view, shape (6,).
    seconds : float
        How long ago that was [s].
    memory_time : float
        After which that place counts for 1/e [s].
    shape : (int, int)
        Rows and columns of the picture.
    """

    last: FloatArray
    seconds: float
    memory_time: float
    shape: tuple[int, int]

    def aged(self, dt: float) -> Births:
        """Return it `dt` seconds later."""
        return replace(self, seconds=self.seconds + dt)

    @property
    def memory_share(self) -> float:
        """Share of the births about the last place."""
        return share_about_last_place(self.seconds, self.memory_time)

    def _spreads(self) -> tuple[float, float, float]:
        width = self.shape[1]
        return (
            width * min(FIRST_SPREAD + SPREADING * self.seconds, WIDEST),
            min(SCALE_SPREAD + SCALE_SPREADING * self.seconds, WIDEST_SCALE),
            min(ANGLE_SPREAD + ANGLE_SPREADING * self.seconds, WIDEST_ANGLE),
        )

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw poses at rest, shape (count, 6)."""
        place, scale, angle = self._spreads()
        noise = standard_student_t(rng, count, PLACES, TAIL)
        states = np.zeros((count, POSE_SIZE))
        states[:, :PLACES] = self.last[:PLACES] + noise * [place, place, scale, angle]
        anywhere = rng.random(count) >= self.memory_share
        height, width = self.shape
        uniform = (rng.random((count, 2)) - 0.5) * [width, height]
        states[anywhere, :2] = uniform[anywhere]
        return states

    def log_density(self, states: FloatArray) -> FloatArray:
        """Return the log-density of the places of poses (N, 6), shape (N,)."""
        place, scale, angle = self._spreads()
        offsets = (states[:, :PLACES] - self.last[:PLACES]) / [place, place, scale, angle]
        squared = offsets**2
        near = log_densities(squared.sum(axis=1), TAIL, PLACES)
        near -= math.log(place * place * scale * angle)
        size = log_densities(squared[:, 2:].sum(axis=1), TAIL, 2) - math.log(scale * angle)
        height, width = self.shape
        within = (np.abs(states[:, PoseColumn.X]) <= width / 2) & (
            np.abs(states[:, PoseColumn.Y]) <= height / 2
        )
        anywhere = np.where(within, size - math.log(width * height), -np.inf)
        share = self.memory_share
        density: FloatArray = np.logaddexp(math.log(share) + near, math.log1p(-share) + anywhere)
        return density
