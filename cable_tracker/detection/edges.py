"""Edges of a picture, as points with a direction."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.tracking.robust import RAYLEIGH_MEDIAN

GRADIENT_FLOOR = 0.5
"""Smallest robust scale of a frame's gradient [grey levels per px]: below it lies the noise."""


@dataclass(frozen=True, slots=True, eq=False)
class Gradient:
    """The gradient of a smoothed picture, y up.

    Attributes
    ----------
    x, y : Image
        Components [grey levels per px], float32, shape (h, w).
    modulus : Image
        Length of the gradient, float32, shape (h, w).
    scale : float
        Robust standard deviation of x and y over the picture, at least `GRADIENT_FLOOR`. A cable
        covers too little of the picture to move the median.
    """

    x: Image
    y: Image
    modulus: Image
    scale: float


def magnitude(x: Image, y: Image) -> Image:
    """Return the lengths of vectors with components of shape (h, w), float32.

    The last bit of what OpenCV returns depends on where the data lie in memory.
    """
    return np.asarray(np.sqrt(x * x + y * y))


def sobel(picture: Image, scale: float = 1.0) -> tuple[Image, Image]:
    """Return the sums of a Sobel filter to the right and upwards, float32, shapes (h, w).

    `scale` is a factor on them; with 1/8 they are the gradient [grey levels per px].
    """
    x = cv2.Sobel(picture, cv2.CV_32F, 1, 0, ksize=3, scale=scale)
    y = cv2.Sobel(picture, cv2.CV_32F, 0, 1, ksize=3, scale=-scale)
    return np.asarray(x), np.asarray(y)


def gradient_of(smooth: Image) -> Gradient:
    """Return the gradient of a picture that is smoothed already, float32 of shape (h, w)."""
    x, y = sobel(smooth, 1 / 8)
    modulus = magnitude(x, y)
    # Every second row and column gives the same in a quarter of the time.
    scale = float(np.median(modulus[::2, ::2])) / RAYLEIGH_MEDIAN
    return Gradient(x, y, modulus, max(scale, GRADIENT_FLOOR))


def gradient_ridge(gradient: Gradient) -> BoolArray:
    """Return the local maxima of the modulus along the gradient's direction, a mask (h, w)."""
    modulus = gradient.modulus
    upright = np.abs(gradient.x) >= np.abs(gradient.y)
    high_across = modulus >= cv2.dilate(modulus, np.ones((1, 3), np.uint8))
    high_down = modulus >= cv2.dilate(modulus, np.ones((3, 1), np.uint8))
    ridge: BoolArray = np.where(upright, high_across, high_down)
    return ridge


@dataclass(frozen=True, slots=True, eq=False)
class EdgePoints:
    """P points on edges.

    Attributes
    ----------
    positions : FloatArray
        x, y in the image frame [px], shape (P, 2).
    directions : FloatArray
        Direction of the gradient [rad], counter-clockwise from +x, (-pi, pi], shape (P,).
    contrasts : FloatArray
        Modulus of the gradient over the frame's scale, shape (P,).
    """

    positions: FloatArray
    directions: FloatArray
    contrasts: FloatArray

    def __len__(self) -> int:
        return len(self.directions)

    def selected(self, chosen: BoolArray) -> EdgePoints:
        """Return the points of a mask of shape (P,)."""
        return EdgePoints(self.positions[chosen], self.directions[chosen], self.contrasts[chosen])

    def within(self, region: SearchRegion | None) -> EdgePoints:
        """Return the points that a region covers; all of them without a region."""
        return self if region is None else self.selected(region.covers(self.positions))
