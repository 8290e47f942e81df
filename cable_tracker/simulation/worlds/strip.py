"""The cable's own coordinates in a picture: straight borders, a plane in perspective."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.state import ANGLE, SKEW, WIDTH
from cable_tracker.tracking.image_frame import to_image

LEAST_SCALE = 0.06
"""The ground is not followed farther than to where it is so small, relative to the foot point."""


@dataclass(frozen=True, slots=True, eq=False)
class StripView:
    """Coordinates of pixels on the bottom relative to a cable, float32 arrays of one shape.

    Attributes
    ----------
    u : Image
        Across the cable [radii]: its borders are at -1 and 1.
    v : Image
        Along it, from its foot point [radii].
    radius : Image
        Extent of a radius in the picture there [px].
    """

    u: Image
    v: Image
    radius: Image


def pixel_grid(image_size: tuple[int, int]) -> tuple[Image, Image]:
    """Return x and y of all pixels in the image frame, float32, shape (H, W) each [px]."""
    width, height = image_size
    x, y = to_image(
        np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32), image_size
    )
    columns, rows = np.meshgrid(x, y)
    return columns, rows


def view_strip(state: FloatArray, x: Image, y: Image) -> StripView:
    """Return the coordinates of image points on the bottom, relative to a cable.

    Parameters
    ----------
    state : FloatArray
        d, alpha, w, beta first, shape (4,) or more [px, rad].
    x, y : Image
        Coordinates in the image frame [px].
    """
    distance, angle, width, skew = (float(value) for value in state[:4])
    cos, sin = np.float32(np.cos(angle)), np.float32(np.sin(angle))
    across = x * cos + y * sin - np.float32(distance)
    along = y * cos - x * sin
    half = np.float32(width / 2)
    radius = half - along * np.float32(np.tan(skew))
    radius = np.maximum(radius, np.float32(LEAST_SCALE) * half)
    return StripView(across / radius, along / radius, radius)


def border_points(
    state: FloatArray, image_size: tuple[int, int], spacing: float
) -> tuple[Image, Image]:
    """Return points along both borders inside an image, at a spacing [px].

    Returns
    -------
    (Image, Image)
        x and y of the left border's points, then of the right one's, float32, shape (1, K) [px].
    """
    distance, angle, half = state[0], state[ANGLE], state[WIDTH] / 2
    reach = float(np.hypot(*image_size)) / 2 + abs(float(distance)) + float(half)
    along = np.arange(-reach, reach, spacing)
    offset = half - along * np.tan(state[SKEW])
    usable = offset > LEAST_SCALE * half
    across = distance + np.concatenate((-offset[usable], offset[usable]))
    along = np.concatenate((along[usable], along[usable]))
    x = across * np.cos(angle) - along * np.sin(angle)
    y = across * np.sin(angle) + along * np.cos(angle)
    width, height = image_size
    inside = (np.abs(x) <= (width - 1) / 2) & (np.abs(y) <= (height - 1) / 2)
    return x[inside][None].astype(np.float32), y[inside][None].astype(np.float32)
