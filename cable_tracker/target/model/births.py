"""Density of the poses at which a target comes into view."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled
from cable_tracker.particle_filter.student_t import (
    log_peak_density,
    relative_log_density,
    standard_student_t,
)
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.state import ANGLE, LOG_SCALE, POSE_SIZE, STATE_SIZE, X, Y

TAIL = 4.0
"""Degrees of freedom about the last place."""

FIRST_SPREAD, SPREADING, WIDEST = 0.1, 0.35, 0.5
"""Scale of the position about the last one: at first, growth per second, and at most [widths]."""

SCALE_SPREAD, SCALE_SPREADING, WIDEST_SCALE = 0.25, 0.15, 0.6
"""The same of the log scale."""

ANGLE_SPREAD, ANGLE_SPREADING, WIDEST_ANGLE = 0.15, 0.3, 0.8
"""The same of the angle [rad]."""

TURN = 2.0 * math.pi


@dataclass(frozen=True, slots=True, eq=False)
class Births:
    """Density of the poses of a target that appears.

    Attributes
    ----------
    last : FloatArray
        Pose when it was last in view, shape (6,).
    seconds : float
        Time since then [s].
    shape : (int, int)
        Rows and columns of the picture.
    """

    last: FloatArray
    seconds: float
    shape: tuple[int, int]

    def aged(self, dt: float) -> Births:
        """Return the density `dt` seconds later."""
        return replace(self, seconds=self.seconds + dt)

    def moved(self, motion: CameraMotion, zoom: float) -> Births:
        """Return the density after a motion of the camera; `zoom` frame pixels are one of a pose.

        A last place that would leave the picture stays: outside it is no use for the search, and if
        the motion is wrong, the target is still there.
        """
        last = motion.moved(self.last[None], zoom)[0]
        height, width = self.shape
        is_out = abs(last[X]) > width / 2 or abs(last[Y]) > height / 2
        return self if is_out else replace(self, last=last)

    def _spreads(self) -> tuple[float, float, float]:
        width = self.shape[1]
        return (
            width * min(FIRST_SPREAD + SPREADING * self.seconds, WIDEST),
            min(SCALE_SPREAD + SCALE_SPREADING * self.seconds, WIDEST_SCALE),
            min(ANGLE_SPREAD + ANGLE_SPREADING * self.seconds, WIDEST_ANGLE),
        )

    def draw(self, count: int, memory_share: float, rng: np.random.Generator) -> FloatArray:
        """Draw poses at rest, shape (count, 6), `memory_share` of them about the last place."""
        place, scale, angle = self._spreads()
        noise = standard_student_t(rng, count, POSE_SIZE, TAIL)
        states = np.zeros((count, STATE_SIZE))
        states[:, :POSE_SIZE] = self.last[:POSE_SIZE] + noise * [place, place, scale, angle]
        anywhere = rng.random(count) >= memory_share
        height, width = self.shape
        uniform = (rng.random((count, 2)) - 0.5) * [width, height]
        states[anywhere, :2] = uniform[anywhere]
        return states

    def log_density(self, states: FloatArray, memory_share: float) -> FloatArray:
        """Return the log-density of the places of poses (N, 6), shape (N,); see `draw`."""
        spreads = np.array(self._spreads())
        return _log_densities(states, self.last, spreads, memory_share, self.shape)


PEAKS = log_peak_density(TAIL, POSE_SIZE), log_peak_density(TAIL, 2)
"""Log-density at the middle for a unit scale: of the whole place, and of scale and angle."""


@compiled
def _log_densities(
    states: FloatArray,
    last: FloatArray,
    spreads: FloatArray,
    memory_share: float,
    shape: tuple[int, int],
) -> FloatArray:
    place, scale, angle = spreads[0], spreads[1], spreads[2]
    (peak, size_peak), (height, width) = PEAKS, shape
    near_peak = peak - math.log(place * place * scale * angle) + math.log(memory_share)
    far_peak = size_peak - math.log(scale * angle * width * height) + math.log1p(-memory_share)
    densities = np.empty(len(states))
    for row in range(len(states)):
        across = (states[row, X] - last[X]) / place
        up = (states[row, Y] - last[Y]) / place
        stretch = (states[row, LOG_SCALE] - last[LOG_SCALE]) / scale
        turned = states[row, ANGLE] - last[ANGLE]
        # Angles of poses and of the last place may be whole turns apart.
        turn = (turned - TURN * math.floor(turned / TURN + 0.5)) / angle
        by_size = stretch * stretch + turn * turn
        squared = across * across + up * up + by_size
        near = near_peak + relative_log_density(squared, TAIL, POSE_SIZE)
        if abs(states[row, X]) <= width / 2 and abs(states[row, Y]) <= height / 2:
            far = far_peak + relative_log_density(by_size, TAIL, 2)
            most, least = max(near, far), min(near, far)
            near = most + math.log1p(math.exp(least - most))
        densities[row] = near
    return densities
