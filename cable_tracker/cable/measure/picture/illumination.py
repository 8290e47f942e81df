"""Lamps light the middle of a picture and leave its edges dark: taking a part of that out.

Grey levels are the light that falls on the bottom times what the bottom reflects, so in a dim part
of the picture a border is as clear to the eye as in a bright one, but its gradient is smaller. A
surface that is smooth over the whole picture, and cannot follow a cable or a shadow, is fitted to
the light. Where it is dim, grey levels are raised. Not by all of it: noise is raised as well. And
not where the surface explains little of the picture: a wide pipe bends it, too.
"""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cholesky import cholesky_factor, solve_factored
from cable_tracker.compilation import compiled, compiled_fast_part, compiled_loop
from cable_tracker.tracking.robust import median_of_sizes, robust_scale

CELLS = (20, 15)
"""Columns and rows of cells, to whose mean grey levels the light is fitted."""

DEGREE = 2
"""Degree of the polynomial in x and y that stands for the logarithm of the light."""

FITS, TUNING = 4, 2.0
"""Number of reweighted least-squares iterations, and tuning constant in robust standard deviations.
Cells of cables, shadows and glare lose weight."""

SMALLEST_DEVIATION = 0.02
"""Lower bound of the robust standard deviation of the residuals [log grey levels]."""

DOUBTED, TRUSTED = 0.6, 0.85
"""A surface that explains a smaller share of the variance than the first is not of light; one that
explains more than the second is."""

DARKEST = 0.1
"""Light below this share of its mean is not raised any further than that: noise is left there."""

ROUNDING = 1.0
"""Added to grey levels before the logarithm: what lies below is rounding."""


def evenly_lit(picture: Image, share: float) -> Image:
    """Return a picture with a share of the unevenness of its light taken out.

    Parameters
    ----------
    picture : Image
        Grey levels, uint8 or float32, shape (h, w).
    share : float
        Power of the light that the picture is divided by: 0 leaves it as it is, 1 makes the light
        even. Less of it counts if little of the picture is explained by light.

    Returns
    -------
    Image
        float32, shape (h, w), of about the same mean; `picture` itself if there is nothing to do.
    """
    if share == 0.0:
        return picture
    height, width = picture.shape
    levels = np.asarray(picture, np.float32)
    means = cv2.resize(levels, CELLS, interpolation=cv2.INTER_AREA)
    logarithms = np.log(np.maximum(means.astype(np.float64).ravel(), 0.0) + ROUNDING)
    fitted, unexplained = _robust_fit(logarithms, _polynomial())
    explained = 1.0 - unexplained
    share *= min(max((explained - DOUBTED) / (TRUSTED - DOUBTED), 0.0), 1.0)
    if share == 0.0:
        return picture
    light = np.exp(fitted).reshape(means.shape)
    mean = float(light.sum()) / light.size
    gain = ((1.0 + DARKEST) * mean / (light + DARKEST * mean)) ** share
    gains = cv2.resize(gain.astype(np.float32), (width, height), interpolation=cv2.INTER_LINEAR)
    return np.asarray(cv2.multiply(levels, gains, dst=gains))


@compiled
def _robust_fit(levels: FloatArray, terms: FloatArray) -> tuple[FloatArray, float]:
    """Return a robust fit of terms (6, C) to the levels of cells (C,).

    Returns
    -------
    fitted : FloatArray
        Logarithm of the light at each cell, shape (C,).
    unexplained : float
        Variance of the residuals over that of the levels.
    """
    fitted, residuals = np.empty(len(levels)), np.empty(len(levels))
    sizes = np.empty(len(levels), np.float32)
    for cell in range(len(levels)):
        sizes[cell] = levels[cell]
    middle = median_of_sizes(sizes)
    for cell in range(len(levels)):
        fitted[cell] = middle
    for _ in range(FITS):
        for cell in range(len(levels)):
            sizes[cell] = abs(levels[cell] - fitted[cell])
        deviation = max(robust_scale(sizes), SMALLEST_DEVIATION)
        _fit(levels, terms, TUNING * deviation, fitted)
    for cell in range(len(levels)):
        residuals[cell] = levels[cell] - fitted[cell]
    return fitted, _variance(residuals) / max(_variance(levels), SMALLEST_DEVIATION**2)


@compiled_loop
def _variance(values: FloatArray) -> float:
    # Within a kernel NumPy's own takes long to compile.
    total, squares = 0.0, 0.0
    for value in values:
        total += value
    for value in values:
        squares += (value - total / len(values)) ** 2
    return squares / len(values)


@compiled_fast_part
def _fit(levels: FloatArray, terms: FloatArray, tuning: float, fitted: FloatArray) -> None:
    """Replace a fit by one of least squares, in which cells weigh less the less the first fits."""
    size, count = terms.shape
    normal, factor = np.empty((size, size)), np.empty((size, size))
    coefficients, weights = np.empty(size), np.empty(count)
    for cell in range(count):
        doubt = (levels[cell] - fitted[cell]) / tuning
        share = 1.0 + doubt * doubt
        weights[cell] = 1.0 / (share * share)
    for row in range(size):
        for column in range(row + 1):
            total = 0.0
            for cell in range(count):
                total += weights[cell] * terms[row, cell] * terms[column, cell]
            normal[row, column] = total
        total = 0.0
        for cell in range(count):
            total += weights[cell] * terms[row, cell] * levels[cell]
        coefficients[row] = total
    cholesky_factor(normal, factor)
    solve_factored(factor, coefficients)
    for cell in range(count):
        fitted[cell] = 0.0
        for row in range(size):
            fitted[cell] += coefficients[row] * terms[row, cell]


@cache
def _polynomial() -> FloatArray:
    """Return the terms of the polynomial in each cell, shape (6, 300)."""
    across, down = CELLS
    x = (np.arange(across) + 0.5) / across * 2.0 - 1.0
    y = (np.arange(down) + 0.5) / down * 2.0 - 1.0
    grid_y, grid_x = np.meshgrid(y, x, indexing="ij")
    terms = [
        (grid_x**first * grid_y**second).ravel()
        for first in range(DEGREE + 1)
        for second in range(DEGREE + 1 - first)
    ]
    return np.array(terms)
