"""A soft shape prior: log-odds that a pixel is inside, by its distance from a known outline."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray
from cable_tracker.libraries import without_ipp


def signed_distances(mask: BoolArray) -> NDArray[np.float32]:
    """Return the distance of every pixel from the outline of a mask, negative inside [px].

    The outline runs between the pixels: the nearest on either side are half a pixel off. What lies
    beyond the picture is outside. All outside has no outline: every distance is the picture's
    diagonal less half a pixel.
    """
    inside = np.pad(mask, 1).astype(np.uint8)
    to_outside, to_inside = _distances_to_zero(inside), _distances_to_zero(1 - inside)
    if not mask.any():
        height, width = mask.shape
        to_inside = np.full(inside.shape, np.hypot(height, width), np.float32)
    signed = np.where(inside > 0, 0.5 - to_outside, to_inside - 0.5)
    cut: NDArray[np.float32] = signed[1:-1, 1:-1].astype(np.float32)
    return cut


def _distances_to_zero(values: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the distance of every pixel from the nearest zero [px]."""
    with without_ipp():
        distances = cv2.distanceTransform(values, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return distances.astype(np.float32, copy=False)


def log_odds(distances: NDArray[np.float32], softness: float, limit: float) -> NDArray[np.float32]:
    """Return the log-odds of being inside, given the distances from an expected outline.

    Parameters
    ----------
    distances : array
        Signed distances from the outline, negative inside, float32, shape (H, W).
    softness : float
        Distance from the outline at which the odds are e : 1, in the unit of `distances`.
    limit : float
        Largest log-odds.
    """
    odds: NDArray[np.float32] = np.clip(-distances / np.float32(softness), -limit, limit)
    return odds
