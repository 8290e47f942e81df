"""One contour a frame: the outline of the target at the estimated pose."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.compilation import compiled
from cable_tracker.contour.evolution import FEWEST, ContourSettings, evolve
from cable_tracker.contour.shapes import log_odds
from cable_tracker.target.model.state import ANGLE, LOG_SCALE, X, Y
from cable_tracker.target.model.template import UNIT, Template, interpolated
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.image_frame import Window, bounding_box, to_pixel

MARGIN = 1.4
"""The window reaches this much farther than the template."""

PRIOR_LIMIT = 6.0
"""Largest log-odds of the prior."""


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A mask in a window of the working image.

    Attributes
    ----------
    mask : BoolArray
        Pixels inside, shape (bottom - top, right - left).
    window : Window
        Window of the mask in the working image.
    overlap : float
        Intersection over union with the template at the estimated pose.
    """

    mask: BoolArray
    window: Window
    overlap: float

    @property
    def area(self) -> int:
        """Pixels inside."""
        return int(self.mask.sum())

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, top, right, bottom from the top left corner [px]; of an empty mask, the window."""
        box = bounding_box(self.mask)
        if box is None:
            left, top, right, bottom = self.window
            return float(left), float(top), float(right), float(bottom)
        left, top = self.window[:2]
        return float(left + box[0]), float(top + box[1]), float(left + box[2]), float(top + box[3])

    def corners(self, zoom: float) -> FloatArray:
        """Return the corners of the largest outer contour, from the frame's top left, shape (K, 2).

        `zoom` pixels of the frame are one of the working image.
        """
        contours, _ = cv2.findContours(
            self.mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
        )
        if not contours:
            return np.empty((0, 2))
        largest = max(contours, key=cv2.contourArea)[:, 0].astype(np.float64)
        corners: FloatArray = (largest + self.window[:2] + 0.5) * zoom
        return corners

    def in_picture(self, shape: tuple[int, int]) -> BoolArray:
        """Return the mask in a picture of this shape."""
        whole = np.zeros(shape, np.bool_)
        left, top, right, bottom = self.window
        whole[top:bottom, left:right] = self.mask
        return whole

    def touches_border(self, shape: tuple[int, int]) -> bool:
        """Return whether the mask reaches the border of a picture of this shape."""
        left, top, right, bottom = self.box
        return left <= 0 or top <= 0 or right >= shape[1] or bottom >= shape[0]


def window_about(state: FloatArray, template: Template, shape: tuple[int, ...]) -> Window | None:
    """Return the window about a pose; None where it lies beyond the picture."""
    height, width = shape
    reach = MARGIN * template.reach * template.size * math.exp(state[LOG_SCALE]) + 2.0
    column, row = to_pixel(state[X], state[Y], (width, height))
    left, right = max(int(column - reach), 0), min(int(column + reach) + 2, width)
    top, bottom = max(int(row - reach), 0), min(int(row + reach) + 2, height)
    if right - left < 3 or bottom - top < 3:
        return None
    return left, top, right, bottom


def find_outline(
    ratios: NDArray[np.float32],
    state: FloatArray,
    template: Template,
    softness: float,
    parameters: TargetParameters,
) -> Outline | None:
    """Let the template's outline at a pose evolve on the map of log-ratios.

    Parameters
    ----------
    ratios : array
        Float32, shape (H, W).
    state : FloatArray
        Pose, shape (6,).
    softness : float
        Distance from its outline at which the prior's odds are e : 1, in units of the template.
    parameters : TargetParameters
        Regulariser and iterations of the contour.

    Returns
    -------
    Outline or None
        None where hardly anything of the pose is in the picture.
    """
    window = window_about(state, template, ratios.shape)
    if window is None:
        return None
    left, top, right, bottom = window
    height, width = ratios.shape
    column, row = to_pixel(state[X], state[Y], (width, height))
    size = template.size * math.exp(state[LOG_SCALE])
    distances = distances_at(
        template.distances,
        column - left,
        row - top,
        size,
        state[ANGLE],
        bottom - top,
        right - left,
    )
    expected = distances < 0.0
    count = int(expected.sum())
    if count < FEWEST or expected.size - count < FEWEST:
        return None
    prior = log_odds(distances, softness, PRIOR_LIMIT)
    settings = ContourSettings(parameters.contour_regulariser, -1.0, parameters.contour_iterations)
    mask = evolve(ratios[top:bottom, left:right] + prior, expected, settings, by_means=False).mask
    overlap = float((mask & expected).sum() / max(int((mask | expected).sum()), 1))
    return Outline(mask, window, overlap)


@compiled
def distances_at(
    template: NDArray[np.float32],
    column: float,
    row: float,
    size: float,
    angle: float,
    height: int,
    width: int,
) -> NDArray[np.float32]:
    """Return the distances from a template's outline at a pose, in units, shape (height, width).

    Parameters
    ----------
    template : array
        Distances of the template from its outline, shape (S, S).
    column, row : float
        Pixel of the template's origin [px].
    size : float
        Length of a unit [px].
    angle : float
        Counter-clockwise [rad].
    height, width : int
        Size of the result [px].
    """
    result = np.empty((height, width), np.float32)
    middle = (len(template) - 1) / 2
    cosine, sine = math.cos(angle) * UNIT / size, math.sin(angle) * UNIT / size
    for i in range(height):
        for j in range(width):
            across, up = j - column, row - i
            x = middle + cosine * across + sine * up
            y = middle + sine * across - cosine * up
            value, beyond = interpolated(template, x, y)
            result[i, j] = value + beyond / UNIT
    return result
