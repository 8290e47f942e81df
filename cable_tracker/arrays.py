"""Array types used in signatures all over the package, and what many do with arrays."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
"""States, weights, covariances: always float64."""

Float32Array: TypeAlias = NDArray[np.float32]
"""Weights, ratios and filters of kernels that run in float32."""

IndexArray: TypeAlias = NDArray[np.int64]
"""Indices of particles."""

BoolArray: TypeAlias = NDArray[np.bool_]
"""Masks."""

Image: TypeAlias = NDArray[Any]
"""Pixels, (H, W) grey or (H, W, 3) blue-green-red; dtype said where it matters."""


def eight_bits(image: Image) -> Image:
    """Return grey levels 0..255 as uint8: rounded and clipped, or the image itself if it is uint8.

    Parameters
    ----------
    image : Image
        Any shape, finite.
    """
    if image.dtype == np.uint8:
        return image
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


def true_runs(mask: BoolArray) -> list[tuple[int, int]]:
    """Return first and last + 1 of each unbroken run of True, in a mask of shape (N,)."""
    edges = np.flatnonzero(np.diff(mask.astype(np.int8), prepend=0, append=0))
    return [(int(first), int(end)) for first, end in edges.reshape(-1, 2)]


def interpolated(asked: FloatArray | float, known: FloatArray, columns: FloatArray) -> FloatArray:
    """Return columns (N, C), known at growing places (N,), at others (M,), shape (M, C).

    At one place the shape is (C,). Before the first and after the last they stay as they are there.
    """
    return np.stack([np.interp(asked, known, column) for column in columns.T], axis=-1)


def shares_of(values: FloatArray) -> FloatArray:
    """Return values (N,) that are not negative, scaled to sum to one; even shares if all are 0."""
    total = values.sum()
    return values / total if total > 0.0 else np.full(len(values), 1.0 / len(values))


def sigma_points(mean: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return 2n points, equally weighted, that have a mean (n,) and a covariance (n, n).

    Shape (2n, n). Polynomials of up to the third degree keep their mean exactly.

    References
    ----------
    I. Arasaratnam and S. Haykin (2009), "Cubature Kalman filters".
    """
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    unit = np.where(sigma > 0.0, sigma, 1.0)
    # px and rad differ by orders of magnitude; correlations do not.
    values, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    root = unit[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    steps = np.sqrt(len(mean)) * root.T
    return np.concatenate((mean + steps, mean - steps))


def mean_and_covariance(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return mean (k,) and covariance (k, k) of equally weighted points (N, k)."""
    mean = points.mean(axis=0)
    offsets = points - mean
    return mean, offsets.T @ offsets / len(points)
