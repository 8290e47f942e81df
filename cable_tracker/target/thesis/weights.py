"""Weights of blobs: (30) as printed, as the sentence before it describes, and a ratio."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray

IMAGE_SHARE = 0.5
"""l_cv of (30); that of the shape is the rest."""

SHAPE_UNIT = 25.0
"""Shape energy of weight 1/e in the other two forms [px² of an image 320 px wide]; our choice."""

ENERGY_UNIT = 1e-3
"""Image energy of weight 1/e in the product: the thesis leaves its unit open; our choice."""

RATIO_SHARPNESS = 2.0
"""Log-weight per unit of contrast over the spread, in the ratio; our choice."""


def blob_weights(
    image_energies: FloatArray, shape_energies: FloatArray, contrasts: FloatArray, form: str
) -> FloatArray:
    """Return the weights of N blobs, summing to one.

    Parameters
    ----------
    image_energies, shape_energies : FloatArray
        E_cv per pixel and E_S [px² of an image 320 px wide], shape (N,); infinite where there is no
        contour.
    contrasts : FloatArray
        Differences of the means.
    form : str
        `eq30`: l_cv e^-E_cv / sum + l_s (1 - E_S / sum E_S), which gives the image hardly a share;
        `product`: e^-E_cv e^-E_S; `likelihood_ratio`: two regions against one, that is the contrast
        over the spread that the two means leave.
    """
    possible = np.isfinite(image_energies) & np.isfinite(shape_energies)
    if not possible.any():
        return np.full(len(possible), 1.0 / len(possible))
    image, shape = image_energies[possible], shape_energies[possible]
    weights = np.zeros(len(possible))
    if form == "eq30":
        likely = np.exp(-image)
        weights[possible] = IMAGE_SHARE * likely / likely.sum()
        total = shape.sum()
        unlike = shape / total if total > 0.0 else np.zeros_like(shape)
        weights[possible] += (1.0 - IMAGE_SHARE) * (1.0 - unlike)
    else:
        logs = -shape / SHAPE_UNIT
        if form == "product":
            logs = logs - image / ENERGY_UNIT
        else:
            logs = logs + RATIO_SHARPNESS * contrasts[possible] / np.sqrt(image + ENERGY_UNIT)
        weights[possible] = np.exp(logs - logs.max())
    shares: FloatArray = weights / weights.sum()
    return shares
