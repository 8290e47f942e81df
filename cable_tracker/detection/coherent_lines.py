"""Lines along which a picture steps the same way all along, however little.

A faint border is lost among the gradients of the bottom, none of which is strong where it runs;
but along it they all have one sign. So the gradients of a coarse picture are projected onto each
direction and summed along its lines (a Radon transform), and a sum is judged by the root of the sum
of its squares: a few strong edges that lie on a line by chance weigh little against many weak ones
that agree.

Two pictures are searched: that of the brightness, and that of the texture, in which a smooth cable
on a rough bottom is a dark strip whatever its grey level.

The constants were chosen on the simulated worlds to tune on (`tune_*`).
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.compilation import compiled, compiled_inside
from cable_tracker.detection.edges import magnitude, sobel
from cable_tracker.detection.vote_peaks import (
    ANGLE_BINS,
    DIRECTIONS,
)

CELL = 4.0
"""Side of a cell of the coarse pictures [px at the reference width]."""

FEWEST_CELLS = 8
"""Least number of cells on a side of a picture that is searched for lines."""

GRADIENT_CAP = 3.0
"""Upper bound of the length of a gradient, in medians of all."""

ORDINARY_SQUARE, LEAST_CELLS = 0.5, 4.0
"""Regulariser: ORDINARY_SQUARE max(cells, LEAST_CELLS) is added to the sum of squares [squared
medians]."""

WHOLE_LENGTH = 0.5
"""Lines that are shorter than this share of the shorter side of the picture count less."""

TEXTURE_SIGMA = 1.0
"""Smoothing before the texture is worked out [px at the reference width], and of it [cells]."""

SMALLEST_TEXTURE_SIGMA = 0.5
"""Lower bound of that smoothing [px]."""

DARK_SHARE = 0.1
"""Share of the mean grey level that is added to grey levels before gradients are divided by them:
in the dark there is little but noise."""

EVEN_SHARE = 0.01
"""Share of the mean texture that is added to it before its logarithm is taken."""

TINY = 1e-6
"""Added where a picture may be of one grey level."""


def coarse_brightness(image: WorkingImage) -> Image:
    """Return the grey levels by cell, float32, shape (m, n)."""
    return _by_cell(image.pixels, image)


def coarse_texture(image: WorkingImage) -> Image:
    """Return the logarithm of the gradient over the grey level by cell, float32, shape (m, n)."""
    sigma = max(TEXTURE_SIGMA * image.scale, SMALLEST_TEXTURE_SIGMA)
    smooth = np.asarray(cv2.GaussianBlur(image.pixels, (0, 0), sigma))
    level = np.maximum(smooth, 0.0) + DARK_SHARE * max(float(smooth.mean()), 0.0) + TINY
    texture = _by_cell(magnitude(*sobel(smooth)) / level, image)
    texture = np.asarray(cv2.GaussianBlur(texture, (0, 0), TEXTURE_SIGMA))
    return np.log(texture + EVEN_SHARE * float(texture.mean()) + TINY)


def _by_cell(picture: Image, image: WorkingImage) -> Image:
    size = tuple(max(int(side / (CELL * image.scale)), 1) for side in image.size)
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))


def coherent_votes(picture: Image) -> Image:
    """Return the agreement of the gradients along each line of a coarse picture.

    Parameters
    ----------
    picture : Image
        float32, shape (m, n).

    Returns
    -------
    Image
        By direction in which it gets brighter, and offset in cells, as `strongest_lines` takes
        them: float32, shape (ANGLE_BINS, 2 middle + 1).
    """
    right, up = sobel(picture)
    lengths = magnitude(right, up)
    median = max(float(np.median(lengths)), TINY)
    factor = np.minimum(1.0 / median, GRADIENT_CAP / np.maximum(lengths, TINY))
    votes = np.zeros((ANGLE_BINS, 2 * middle_offset(picture) + 1), np.float32)
    shortest = WHOLE_LENGTH * min(picture.shape)
    _project(right * factor, up * factor, shortest, votes)
    return votes


def middle_offset(picture: Image) -> int:
    """Return the number of the bin of offset zero."""
    return int(np.hypot(*picture.shape) / 2) + 2


@compiled
def _project(right: Image, up: Image, whole: float, votes: Image) -> None:
    """Fill in the votes."""
    rows, columns = right.shape
    bins = votes.shape[1]
    middle, half = bins // 2, ANGLE_BINS // 2
    sums = np.empty((3, bins), np.float32)
    for angle in range(half):
        cosine, sine = np.float32(DIRECTIONS[0, angle]), np.float32(DIRECTIONS[1, angle])
        sums[:] = np.float32(0.0)
        for row in range(rows):
            # Upwards from the middle; half a bin more, which rounds to the nearest.
            start = (0.5 * (rows - 1) - row) * sine - 0.5 * (columns - 1) * cosine + middle + 0.5
            for column in range(columns):
                across = right[row, column] * cosine + up[row, column] * sine
                offset = int(start + column * cosine)
                sums[0, offset] += across
                sums[1, offset] += across * across
                sums[2, offset] += np.float32(1.0)
        for offset in range(bins):
            agreed = _agreement(sums[0, offset], sums[1, offset], sums[2, offset], whole)
            votes[angle, offset] = max(agreed, 0.0)
            votes[half + angle, bins - 1 - offset] = max(-agreed, 0.0)


@compiled_inside
def _agreement(total: float, squares: float, cells: float, whole: float) -> float:
    """Return a sum over the root of the sum of squares, less for a short line."""
    spread = math.sqrt(squares + ORDINARY_SQUARE * max(cells, LEAST_CELLS))
    return total / spread * math.sqrt(min(cells / whole, 1.0))
