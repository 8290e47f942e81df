"""Gradients of a frame, worked out once and read at many points.

Two things are known at every pixel: the gradient of the smoothed picture, and the gradient of its
modulus. The first, projected on the normal of a line, is the response of a derivative-of-Gaussian
filter across that line. The second tells on which side the edge is, and how far away: on the ridge
of an edge it vanishes, beside it it points to the ridge.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image

GAUSSIAN_MAD = 1.4826
"""Standard deviation of a Gaussian over its median absolute deviation."""

NOISE_FLOOR = 0.1
"""Smallest robust scale of a frame [grey levels per px]: below it lies the rounding of pixels."""

SCALE_STEP = 4
"""The robust scale is taken over every fourth row and column: they say the same as all."""

MAP_COLUMNS = 4096
"""Row length of the look-up map; OpenCV takes at most 32767 rows or columns of it."""

DIFFERENCE = np.array([-0.5, 0.0, 0.5], np.float32)
NOTHING = np.array([1.0], np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class GradientField:
    """Gradients of a picture in units of the picture's own noise, y up.

    Attributes
    ----------
    channels : Image
        Gradient x, y and gradient of its modulus x, y, float32, shape (h, w, 4). The first two in
        units of `scale`, the others in `scale` per pixel.
    scale : float
        Robust standard deviation of the gradient over the picture [grey levels per px]. A cable
        covers too little of it to move the median.
    """

    channels: Image
    scale: float


def read_channels(picture: Image, columns: FloatArray, rows: FloatArray) -> Image:
    """Read a float32 picture (h, w) or (h, w, c) at P places, bilinearly; shape (P, c).

    Beyond the edge of the picture its outermost pixels go on.
    """
    count = columns.size
    length = max(1, -(-count // MAP_COLUMNS))  # OpenCV refuses an empty map.
    maps = np.zeros((2, length * MAP_COLUMNS), dtype=np.float32)
    maps[0, :count] = columns
    maps[1, :count] = rows
    x, y = maps.reshape(2, length, MAP_COLUMNS)
    values = np.asarray(cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))
    return values.reshape(length * MAP_COLUMNS, -1)[:count]


def gradient_field(pixels: Image, sigma: float) -> GradientField:
    """Work out the gradients of a picture.

    Parameters
    ----------
    pixels : Image
        Grey levels, float32, shape (h, w).
    sigma : float
        Of the Gaussian that smooths it [px].
    """
    smooth = cv2.GaussianBlur(pixels, (0, 0), sigma)
    x, y = _gradient(smooth)
    modulus_x, modulus_y = _gradient(cv2.magnitude(x, y))
    scale = max(_robust_scale(x, y), NOISE_FLOOR)
    channels = cv2.merge([x, y, modulus_x, modulus_y])
    return GradientField(channels * np.float32(1.0 / scale), scale)


def _gradient(picture: Image) -> tuple[Image, Image]:
    x = cv2.sepFilter2D(picture, cv2.CV_32F, DIFFERENCE, NOTHING)
    # Rows run down where y runs up.
    y = cv2.sepFilter2D(picture, cv2.CV_32F, NOTHING, -DIFFERENCE)
    return x, y


def _robust_scale(x: Image, y: Image) -> float:
    sample = np.abs(np.stack((x[::SCALE_STEP, ::SCALE_STEP], y[::SCALE_STEP, ::SCALE_STEP])))
    return GAUSSIAN_MAD * float(np.median(sample))
