"""The predicted density of the poses in a frame, and the mixtures that particles are drawn from."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.compilation import compiled
from cable_tracker.particle_filter.existence import PredictedExistence
from cable_tracker.particle_filter.student_t import (
    KernelMixture,
    log_peak_density,
    relative_density,
    relative_log_density,
    standard_student_t,
)
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.state import ANGLE, LOG_SCALE, POSE_SIZE, X, Y

NEVER = 1e-300
"""Stands for a probability of zero where its logarithm is needed."""


BIRTH_TAIL = 4.0
"""Degrees of freedom about the last place."""

FIRST_SPREAD, SPREADING, WIDEST = 0.1, 0.35, 0.5
"""Scale of the position about the last one: at first, growth per second, and at most [widths]."""

SCALE_SPREAD, SCALE_SPREADING, WIDEST_SCALE = 0.25, 0.15, 0.6
"""The same of the log scale."""

ANGLE_SPREAD, ANGLE_SPREADING, WIDEST_ANGLE = 0.15, 0.3, 0.8
"""The same of the angle [rad]."""

TURN = 2.0 * math.pi

PEAKS = log_peak_density(BIRTH_TAIL, POSE_SIZE), log_peak_density(BIRTH_TAIL, 2)
"""Log-density at the middle for a unit scale: of the whole place, and of scale and angle."""


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
        """Draw poses, shape (count, 4), `memory_share` of them about the last place."""
        place, scale, angle = self._spreads()
        noise = standard_student_t(rng, count, POSE_SIZE, BIRTH_TAIL)
        poses: FloatArray = self.last[:POSE_SIZE] + noise * [place, place, scale, angle]
        anywhere = rng.random(count) >= memory_share
        height, width = self.shape
        uniform = (rng.random((count, 2)) - 0.5) * [width, height]
        poses[anywhere, :2] = uniform[anywhere]
        return poses

    def log_density(self, states: FloatArray, memory_share: float) -> FloatArray:
        """Return the log-density of the places of poses (N, 6), shape (N,); see `draw`."""
        spreads = np.array(self._spreads())
        return _log_densities(states, self.last, spreads, memory_share, self.shape)


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
        near = near_peak + relative_log_density(squared, BIRTH_TAIL, POSE_SIZE)
        if abs(states[row, X]) <= width / 2 and abs(states[row, Y]) <= height / 2:
            far = far_peak + relative_log_density(by_size, BIRTH_TAIL, 2)
            most, least = max(near, far), min(near, far)
            near = most + math.log1p(math.exp(least - most))
        densities[row] = near
    return densities


@compiled
def relative_kernels(
    points: FloatArray, centres: FloatArray, scales: FloatArray, tail: float
) -> FloatArray:
    """Return Student-t kernels about centres at points, over their peak, shape (N, M).

    Parameters
    ----------
    points, centres : FloatArray
        Shapes (N, 4 or more) and (M, 4).
    scales : FloatArray
        Scales of the kernels along the four axes, shape (4,).
    tail : float
        Degrees of freedom.
    """
    values = np.empty((len(points), len(centres)))
    for row in range(len(points)):
        for column in range(len(centres)):
            squared = 0.0
            for axis in range(POSE_SIZE):
                offset = (points[row, axis] - centres[column, axis]) / scales[axis]
                squared += offset * offset
            values[row, column] = relative_density(squared, tail, POSE_SIZE)
    return values


def log_mix(values: FloatArray, weights: FloatArray, mixture: KernelMixture) -> FloatArray:
    """Return the log-density of kernels (N, M) of a mixture, by weights (M,), shape (N,)."""
    with np.errstate(divide="ignore"):
        mixed: FloatArray = math.log(mixture.peak) + np.log(values @ weights)
    return mixed


def kernels_of(states: FloatArray, mixture: KernelMixture) -> FloatArray:
    """Return the kernels of a mixture at poses (N, 4 or more), over their peak, shape (N, M)."""
    tail = float(mixture.degrees_of_freedom)
    return relative_kernels(states, mixture.places, mixture.scales, tail)


@dataclass(frozen=True, slots=True, eq=False)
class PredictedDensity:
    """The predicted density: of targets that survived, jumped, or came into view.

    Attributes
    ----------
    kernels : KernelMixture
        About the moved ancestors; shape (M, 4) of centres.
    rates : FloatArray
        Rates of the ancestors, shape (M, 2).
    alive : FloatArray
        Shares of the ancestors by their survival, shape (M,), summing to one.
    births : Births
        Density of the poses of targets that jump or come into view.
    memory_share : float
        Share of the births about the last place.
    existence : PredictedExistence
        Probabilities that the target has survived, and that it has come into view.
    jump_share : float
        Share of the survivors that jump.
    """

    kernels: KernelMixture
    rates: FloatArray
    alive: FloatArray
    births: Births
    memory_share: float
    existence: PredictedExistence
    jump_share: float

    def log_density(self, states: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return log-densities at poses (N, 6).

        Returns
        -------
        tuple of FloatArray
            Log-density of the belief, whose mass is the probability that the target is in view,
            shape (N,); that of the births, shape (N,); kernels over their peak, shape (N, M).
        """
        kernels = kernels_of(states, self.kernels)
        birth = self.births.log_density(states, self.memory_share)
        following = (1.0 - self.jump_share) * self.existence.survived
        elsewhere = self.jump_share * self.existence.survived + self.existence.born
        belief: FloatArray = np.logaddexp(
            math.log(max(following, NEVER)) + log_mix(kernels, self.alive, self.kernels),
            math.log(max(elsewhere, NEVER)) + birth,
        )
        return belief, birth, kernels
