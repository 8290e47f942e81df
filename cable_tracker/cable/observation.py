"""The observation model of the thesis: how well the image shows the two borders of a cable."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image
from cable_tracker.cable.geometry import Borders, image_to_pixel, project_borders, sample_points
from cable_tracker.cable.parameters import REFERENCE_WIDTH, TrackerParameters
from cable_tracker.cable.working_image import SMALLEST_SIGMA, WorkingImage

REMAP_COLUMNS = 4096
"""Row length of the look-up map; OpenCV takes at most 32767 rows or columns of it."""

CABLES_AT_ONCE = 512
"""Cables measured in one go, so that it all stays in the cache and memory does not grow with N."""

SMALLEST_SUM = 1e-3
"""Sums below this are the rounding of float32 pixels [grey levels]."""


@dataclass(frozen=True, slots=True, eq=False)
class BorderResponses:
    """What the filter across the borders answered.

    Attributes
    ----------
    sums : FloatArray
        Sum of the responses along each border [grey levels], shape (N, 2): left, right. Positive
        where the image brightens from left to right.
    counts : FloatArray
        Number of points of each border inside the image, shape (N, 2).
    """

    sums: FloatArray
    counts: FloatArray

    def opposed(self) -> BoolArray:
        """Tell which cables have borders of opposite sign, as a strip has; shape (N,).

        A border in a flat part of the image, black or saturated, has no sign.
        """
        clear = np.abs(self.sums).min(axis=1) > SMALLEST_SUM
        opposed: BoolArray = clear & (np.sign(self.sums[:, 0]) != np.sign(self.sums[:, 1]))
        return opposed


def derivative_of_gaussian(taps: int, sigma: float) -> FloatArray:
    """Return the filter f(x) = x / (sigma^3 sqrt(2 pi)) exp(-x^2 / (2 sigma^2)), shape (taps,).

    x runs over whole pixels, symmetric about zero (thesis, section 4.4.1). The thesis writes a
    minus sign for a convolution; this is for a correlation, so that a rise gives a positive answer.
    """
    x = np.arange(taps) - (taps - 1) / 2
    response: FloatArray = x / (sigma**3 * np.sqrt(2 * np.pi)) * np.exp(-(x**2) / (2 * sigma**2))
    return response


def interpolate(pixels: Image, columns: FloatArray, rows: FloatArray) -> Image:
    """Read float32 pixels (h, w) at columns and rows of any one shape, bilinearly.

    Beyond the edge of the picture its outermost pixels go on. Returns float32 of that shape.
    """
    length = max(1, -(-columns.size // REMAP_COLUMNS))  # OpenCV refuses an empty map.
    maps = np.zeros((2, length * REMAP_COLUMNS), dtype=np.float32)
    maps[0, : columns.size] = columns.reshape(-1)
    maps[1, : rows.size] = rows.reshape(-1)
    x, y = maps.reshape(2, length, REMAP_COLUMNS)
    values = cv2.remap(pixels, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(values).reshape(-1)[: columns.size].reshape(columns.shape)


class BorderObservation:
    """Sums of derivative-of-Gaussian responses along the two borders (thesis, section 4.4).

    The weight of a cable is |c_l| + |c_r| if the two border scores have opposite signs, and a small
    epsilon otherwise.

    Parameters
    ----------
    parameters : TrackerParameters
        Filter, spacing, epsilon.
    """

    def __init__(self, parameters: TrackerParameters) -> None:
        self._spacing = parameters.sample_spacing
        self._sigma = parameters.filter_sigma
        self._taps = parameters.filter_taps
        self._log_epsilon = float(np.log(parameters.epsilon))

    def log_likelihoods(self, states: FloatArray, observation: WorkingImage) -> FloatArray:
        """Return the logarithm of each cable's weight, shape (N,), for states (N, 8)."""
        responses = self.measure(project_borders(states), observation)
        strength = np.abs(responses.sums).sum(axis=1)
        opposed = responses.opposed()
        result = np.full(len(states), self._log_epsilon)
        result[opposed] = np.maximum(np.log(strength[opposed]), self._log_epsilon)
        return result

    def measure(self, borders: Borders, image: WorkingImage) -> BorderResponses:
        """Filter across each border at regular points, and sum along it."""
        blocks = [
            self._measure_block(
                Borders(
                    borders.angles[start : start + CABLES_AT_ONCE],
                    borders.offsets[start : start + CABLES_AT_ONCE],
                ),
                image,
            )
            for start in range(0, len(borders.angles), CABLES_AT_ONCE)
        ]
        return BorderResponses(
            np.concatenate([block.sums for block in blocks]),
            np.concatenate([block.counts for block in blocks]),
        )

    def _measure_block(self, borders: Borders, image: WorkingImage) -> BorderResponses:
        points, inside = sample_points(
            borders, self._spacing * image.frame_size[0] / REFERENCE_WIDTH, image.frame_size
        )
        responses = np.zeros(inside.shape)
        responses[inside] = self._respond(
            image, image.to_working(points[inside]), _normals(borders, inside)
        )
        return BorderResponses(responses.sum(axis=2), inside.sum(axis=2).astype(np.float64))

    def respond_at(self, image: WorkingImage, points: FloatArray, angles: FloatArray) -> FloatArray:
        """Return the response at each point across a line through it, shape (P,) [grey levels].

        Parameters
        ----------
        image : WorkingImage
            The frame.
        points : FloatArray
            Shape (P, 2), image frame of the full frame [px].
        angles : FloatArray
            Normal angles of the lines [rad], shape (P,).
        """
        normals = np.stack((np.cos(angles), np.sin(angles)), axis=-1)
        return self._respond(image, image.to_working(points), normals)

    def _respond(self, image: WorkingImage, points: FloatArray, normals: FloatArray) -> FloatArray:
        scale = image.scale
        taps = 2 * round((self._taps - 1) / 2 * scale) + 1 if scale != 1.0 else self._taps | 1
        sigma = max(self._sigma * scale, SMALLEST_SIGMA)
        kernel = derivative_of_gaussian(max(taps, 3), sigma)
        reach = np.arange(len(kernel)) - (len(kernel) - 1) / 2
        pixels = image_to_pixel(points, image.size)
        # Rows run down where y runs up.
        columns = pixels[:, 0, None] + reach * normals[:, 0, None]
        rows = pixels[:, 1, None] - reach * normals[:, 1, None]
        return interpolate(image.pixels, columns, rows) @ kernel


def _normals(borders: Borders, inside: BoolArray) -> FloatArray:
    normals = np.stack((np.cos(borders.angles), np.sin(borders.angles)), axis=-1)
    return np.broadcast_to(normals[:, :, None, :], (*inside.shape, 2))[inside]
