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
from cable_tracker.cable.measure.scanned_gradients import GAUSSIAN_MAD

CELLS = (20, 15)
"""The light is fitted to the mean grey levels of so many cells across and down."""

DEGREE = 2
"""Of the polynomial in x and y that the logarithm of the light is taken to be."""

FITS, TUNING = 4, 2.0
"""So many fits of least squares, after that of a constant; each counts cells less whose residual is
beyond so many robust standard deviations of the last: cables, shadows, glare."""

SMALLEST_DEVIATION = 0.02
"""Of the residuals, for pictures that are lit just so [log grey levels]."""

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
    light, explained = _light(picture)
    share *= min(max((explained - DOUBTED) / (TRUSTED - DOUBTED), 0.0), 1.0)
    if share == 0.0:
        return picture
    mean = float(light.mean())
    gain = ((1.0 + DARKEST) * mean / (light + DARKEST * mean)) ** share
    gains = cv2.resize(gain.astype(np.float32), (width, height), interpolation=cv2.INTER_LINEAR)
    return np.asarray(cv2.multiply(np.asarray(picture, np.float32), gains))


def _light(picture: Image) -> tuple[FloatArray, float]:
    """Return the light that was fitted to a picture, in each cell, and what it explains.

    Shape (15, 20), and a share of the variance of the logarithms of the cells, at most 1.
    """
    means = cv2.resize(np.asarray(picture, np.float32), CELLS, interpolation=cv2.INTER_AREA)
    levels = np.log(np.maximum(means.astype(np.float64).ravel(), 0.0) + ROUNDING)
    terms = _polynomial()
    fitted: FloatArray = np.full(len(levels), np.median(levels))
    for _ in range(FITS):
        residuals = levels - fitted
        deviation = max(GAUSSIAN_MAD * float(np.median(np.abs(residuals))), SMALLEST_DEVIATION)
        weights = 1.0 / (1.0 + (residuals / (TUNING * deviation)) ** 2) ** 2
        weighted = terms * weights[:, None]
        fitted = terms @ np.linalg.solve(weighted.T @ terms, weighted.T @ levels)
    light: FloatArray = np.exp(fitted).reshape(CELLS[1], CELLS[0])
    unexplained = float(np.var(levels - fitted)) / max(float(np.var(levels)), SMALLEST_DEVIATION**2)
    return light, 1.0 - unexplained


@cache
def _polynomial() -> FloatArray:
    """Return the terms of the polynomial in each cell, shape (300, 6)."""
    across, down = CELLS
    x = (np.arange(across) + 0.5) / across * 2.0 - 1.0
    y = (np.arange(down) + 0.5) / down * 2.0 - 1.0
    grid_y, grid_x = np.meshgrid(y, x, indexing="ij")
    terms = [
        (grid_x**first * grid_y**second).ravel()
        for first in range(DEGREE + 1)
        for second in range(DEGREE + 1 - first)
    ]
    return np.stack(terms, axis=1)
