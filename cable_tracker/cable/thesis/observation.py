"""The observation model of the thesis: how well the image shows the two borders of a cable."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image
from cable_tracker.cable.measure.working_image import SMALLEST_SIGMA, WorkingImage
from cable_tracker.cable.model.geometry import (
    Borders,
    image_to_pixel,
    project_borders,
    sample_points,
)
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH, TrackerParameters

REMAP_COLUMNS = 4096
"""Row length of the look-up map; OpenCV takes at most 32767 rows or columns of it."""

GRID_COLUMNS, GRID_ROWS, GRID_DIRECTIONS = 24, 18, 4
"""Places at which the frame's own scale is measured, and directions of the lines through them."""

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


def scaled_filter(parameters: TrackerParameters, scale: float) -> FloatArray:
    """Return the taps of the filter for pictures of some scale to the reference width."""
    taps = parameters.filter_taps | 1
    if scale != 1.0:
        taps = 2 * round((parameters.filter_taps - 1) / 2 * scale) + 1
    return derivative_of_gaussian(
        max(taps, 3), max(parameters.filter_sigma * scale, SMALLEST_SIGMA)
    )


def log_weights_of_responses(responses: BorderResponses, epsilon: float) -> FloatArray:
    """Return the logarithm of |c_l| + |c_r|, or of epsilon where they do not oppose; shape (N,)."""
    strength = np.abs(responses.sums).sum(axis=1)
    opposed = responses.opposed()
    result = np.full(len(strength), np.log(epsilon))
    result[opposed] = np.maximum(np.log(strength[opposed]), np.log(epsilon))
    return result


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
        self._parameters = parameters

    def log_likelihoods(self, states: FloatArray, observation: WorkingImage) -> FloatArray:
        """Return the logarithm of each cable's weight, shape (N,), for states (N, 8)."""
        responses = self.measure(project_borders(states), observation)
        return log_weights_of_responses(responses, self._parameters.epsilon)

    def measure(self, borders: Borders, image: WorkingImage) -> BorderResponses:
        """Filter across each border at regular points, and sum along it."""
        blocks = [self._measure_block(block, image) for block in borders.blocks()]
        return BorderResponses(
            np.concatenate([block.sums for block in blocks]),
            np.concatenate([block.counts for block in blocks]),
        )

    def _measure_block(self, borders: Borders, image: WorkingImage) -> BorderResponses:
        spacing = self._parameters.sample_spacing * image.frame_size[0] / REFERENCE_WIDTH
        points, inside = sample_points(borders, spacing, image.frame_size)
        responses = np.zeros(inside.shape)
        responses[inside] = self._respond(
            image, image.to_working(points[inside]), _normals(borders, inside)
        )
        return BorderResponses(responses.sum(axis=2), inside.sum(axis=2).astype(np.float64))

    def scattered_responses(self, image: WorkingImage) -> FloatArray:
        """Return the filter's answers at places all over the frame [grey levels], shape (G,).

        At a regular grid of points, across lines of four directions.
        """
        points, angles = scattered_lines(image.frame_size)
        normals = np.stack((np.cos(angles), np.sin(angles)), axis=-1)
        return self._respond(image, image.to_working(points), normals).astype(np.float64)

    def _respond(self, image: WorkingImage, points: FloatArray, normals: FloatArray) -> FloatArray:
        kernel = scaled_filter(self._parameters, image.scale)
        reach = np.arange(len(kernel)) - (len(kernel) - 1) / 2
        pixels = image_to_pixel(points, image.size)
        # Rows run down where y runs up.
        columns = pixels[:, 0, None] + reach * normals[:, 0, None]
        rows = pixels[:, 1, None] - reach * normals[:, 1, None]
        return interpolate(image.pixels, columns, rows) @ kernel


def scattered_lines(frame_size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Return points (G, 2) all over the image frame [px], and a normal angle (G,) for each."""
    width, height = frame_size
    x = ((np.arange(GRID_COLUMNS) + 0.5) / GRID_COLUMNS - 0.5) * width
    y = ((np.arange(GRID_ROWS) + 0.5) / GRID_ROWS - 0.5) * height
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return points, np.pi * (np.arange(len(points)) % GRID_DIRECTIONS) / GRID_DIRECTIONS


def _normals(borders: Borders, inside: BoolArray) -> FloatArray:
    normals = np.stack((np.cos(borders.angles), np.sin(borders.angles)), axis=-1)
    return np.broadcast_to(normals[:, :, None, :], (*inside.shape, 2))[inside]
