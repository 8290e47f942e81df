"""How far the ground has moved in the picture, beside a strip that has not.

A patch of the picture to either side of the strip, if there is room for it, is held against the
same place in a later picture: the phase of their cross-power spectrum tells the shift. Ground
without texture, or two patches too far apart, give a peak that is too low, and nothing is told.

References
----------
C. D. Kuglin and D. C. Hines (1975), "The phase correlation image alignment method".
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.geometry import middle_inside
from cable_tracker.cable.model.state import ANGLE, DISTANCE, WIDTH

SIDE = 64
"""Side of a patch [px at the reference width]."""

CLEAR_OF_STRIP = 2.0
"""Distance between the strip and a patch [px at the reference width]."""

LEAST_BESIDE = 0.25
"""Where the edge of the picture pushes a patch over the strip, its centre lies so far outside of
the border at least [sides of a patch]."""

LEAST_RESPONSE = 0.4
"""Height of the peak from which on a shift is believed; 1 for the same picture."""

LARGEST_SHIFT = 0.25
"""Of a larger shift too little of the ground is in both pictures [sides of a patch]."""


class GroundPatches(NamedTuple):
    """Patches of a picture to either side of a strip.

    Attributes
    ----------
    shape : tuple of int
        Height and width of the picture [px].
    corners : tuple of (int, int)
        Column and row of their first pixel, the left side of the strip first [px]; one beside a
        strip at the edge of the picture, else two.
    patches : tuple of Image
        Grey levels, float32, square.
    """

    shape: tuple[int, ...]
    corners: tuple[tuple[int, int], ...]
    patches: tuple[Image, ...]

    def centres(self) -> FloatArray:
        """Return the centres of the patches in the image frame, shape (K, 2) [px]."""
        side = len(self.patches[0])
        return np.array([_centre(corner, side, self.shape) for corner in self.corners])


def patches_beside(pose: FloatArray, picture: Image, scale: float) -> GroundPatches | None:
    """Return the patches beside a strip; None where the picture has no room on either side.

    Parameters
    ----------
    pose : FloatArray
        d, alpha, w and more of the strip [px of the picture, rad].
    picture : Image
        Grey levels, float32, shape (h, w).
    scale : float
        Pixels of the picture per pixel of one of the reference width.
    """
    height, width = picture.shape
    side = round(SIDE * scale)
    middle = middle_inside(float(pose[ANGLE]), float(pose[DISTANCE]), (width, height))
    if middle is None or side > min(width, height):
        return None
    normal = np.array([np.cos(pose[ANGLE]), np.sin(pose[ANGLE])])
    corners = []
    for outwards in (-normal, normal):
        centre = middle + (0.5 * (pose[WIDTH] + side) + CLEAR_OF_STRIP * scale) * outwards
        column = min(max(round(centre[0] + 0.5 * (width - side)), 0), width - side)
        row = min(max(round(0.5 * (height - side) - centre[1]), 0), height - side)
        inside = _centre((column, row), side, picture.shape)
        if (inside - middle) @ outwards >= 0.5 * pose[WIDTH] + LEAST_BESIDE * side:
            corners.append((column, row))
    if not corners:
        return None
    patches = tuple(_patch(picture, corner, side) for corner in corners)
    return GroundPatches(picture.shape, tuple(corners), patches)


def ground_shifts(before: GroundPatches, picture: Image) -> FloatArray | None:
    """Return how far the ground of each patch has moved, x to the right, y up, shape (K, 2) [px].

    None where that cannot be told of all, or the picture has another size than the one before.
    """
    if picture.shape != before.shape:
        return None
    side = len(before.patches[0])
    window = _window(side)
    shifts = []
    for corner, patch in zip(before.corners, before.patches, strict=True):
        (right, down), response = cv2.phaseCorrelate(patch, _patch(picture, corner, side), window)
        if response < LEAST_RESPONSE or max(abs(right), abs(down)) > LARGEST_SHIFT * side:
            return None
        shifts.append((right, -down))
    return np.array(shifts)


def _centre(corner: tuple[int, int], side: int, shape: tuple[int, ...]) -> FloatArray:
    """Return the centre of a patch of a picture (h, w) in the image frame, shape (2,) [px]."""
    (column, row), (height, width) = corner, shape
    return np.array([column - 0.5 * (width - side), 0.5 * (height - side) - row])


def _patch(picture: Image, corner: tuple[int, int], side: int) -> Image:
    """Return a square of a picture, its mean taken off."""
    column, row = corner
    patch = picture[row : row + side, column : column + side]
    return np.asarray(patch - patch.mean())


@cache
def _window(side: int) -> Image:
    """Return the weights of the pixels of a patch: its edges must not pass for texture."""
    return np.asarray(cv2.createHanningWindow((side, side), cv2.CV_32F))
