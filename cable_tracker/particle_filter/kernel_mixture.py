"""A mixture of equal kernels about weighted centres: a cloud of particles as a density."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.particle_filter.student_t import student_t_log_density

POINTS_AT_ONCE = 4096
"""Points whose distances to all centres are held at a time, so that memory does not grow with N."""


@dataclass(frozen=True, slots=True, eq=False)
class KernelMixture:
    """Student-t kernels with independent components.

    Attributes
    ----------
    centres : FloatArray
        Shape (M, k).
    scales : FloatArray
        Of the kernel, shape (k,); positive.
    degrees_of_freedom : float
        Of the kernel; infinite for Gaussian ones.
    """

    centres: FloatArray
    scales: FloatArray
    degrees_of_freedom: float

    def placed_about(self, indices: IndexArray, standard: FloatArray) -> FloatArray:
        """Return one point about each of the centres at `indices`, shape (N, k).

        `standard` holds draws of location zero and unit scale, shape (N, k).
        """
        return self.centres[indices] + standard * self.scales

    def log_densities(self, points: FloatArray, weights: tuple[FloatArray, ...]) -> FloatArray:
        """Return the log-density at points (N, k) for several weightings of the same centres.

        Parameters
        ----------
        points : FloatArray
            Shape (N, k).
        weights : tuple of FloatArray
            Each of shape (M,), summing to one.

        Returns
        -------
        FloatArray
            Shape (len(weights), N).
        """
        columns = np.stack(weights, axis=1)
        blocks = []
        for start in range(0, len(points), POINTS_AT_ONCE):
            kernels = self.log_kernels(points[start : start + POINTS_AT_ONCE])
            peaks = kernels.max(axis=1, keepdims=True)
            # Far from all centres of a positive weight the sum may vanish: that is density zero.
            with np.errstate(divide="ignore"):
                blocks.append((peaks + np.log(np.exp(kernels - peaks) @ columns)).T)
        return np.concatenate(blocks, axis=1)

    def log_kernels(self, points: FloatArray) -> FloatArray:
        """Return the log-density of every kernel at every point, shape (N, M)."""
        a, b = points / self.scales, self.centres / self.scales
        # |a - b|^2 by one matrix product; rounding may leave a distance of zero below it.
        squared = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1) - 2.0 * a @ b.T
        return student_t_log_density(
            np.maximum(squared, 0.0),
            len(self.scales),
            self.degrees_of_freedom,
            float(np.log(self.scales).sum()),
        )
