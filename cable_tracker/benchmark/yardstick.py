"""The yardstick: the observation of the thesis written down literally, and compiled.

No trick and no second thread: every particle, both borders, every point, every tap, read
bilinearly. Other times are given as multiples of its time on the same machine at the same moment,
which is more comparable than milliseconds. It is no part of the tracker.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.initial_state import GivenState, draw_given_states
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.border_response_model import SMALLEST_SUM
from cable_tracker.compilation import compiled

YARDSTICK_SEED = 7

TAPS = 11
"""Length of the thesis' filter [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class Yardstick:
    """The literal observation, ready to be called.

    Attributes
    ----------
    pixels : Image
        Grey levels, float32, shape (240, 320): the size at which lengths need no scaling.
    states : FloatArray
        Cables to weigh, shape (N, 8).
    spacing : float
        Distance of the points along a border [px].
    kernel : FloatArray
        The filter across the border, shape (taps,).
    epsilon : float
        Weight of a cable whose borders do not oppose each other.
    """

    pixels: Image
    states: FloatArray
    spacing: float
    kernel: FloatArray
    epsilon: float

    def __call__(self) -> FloatArray:
        """Return the weight of each cable, shape (N,)."""
        return literal_weights(
            self.pixels, self.states, self.spacing, self.kernel, self.epsilon, SMALLEST_SUM
        )

    def pixels_touched(self) -> int:
        """Return the number of pixels read, if all points lie inside the image."""
        height, width = self.pixels.shape
        points: int = min(2 * int(math.hypot(width, height) / 2 / self.spacing) + 1, height)
        return 8 * len(self.kernel) * points * len(self.states)


def make_yardstick(image: Image, truth: CableState) -> Yardstick:
    """Return the yardstick on a frame of 320x240: the cables lie about the true one."""
    parameters = preset("thesis")
    rng = np.random.default_rng(YARDSTICK_SEED)
    states = draw_given_states(GivenState.around(truth), parameters, image.shape[1], rng)
    return yardstick_of(image, states, parameters)


def yardstick_of(image: Image, states: FloatArray, parameters: TrackerParameters) -> Yardstick:
    """Return the yardstick on a frame 320 px wide, for some cables (N, 8)."""
    return Yardstick(
        np.ascontiguousarray(image, np.float32),
        np.ascontiguousarray(states),
        parameters.sample_spacing,
        derivative_of_gaussian(TAPS, parameters.filter_sigma),
        parameters.epsilon,
    )


def derivative_of_gaussian(taps: int, sigma: float) -> FloatArray:
    """Return the filter f(x) = x / (sigma^3 sqrt(2 pi)) exp(-x^2 / (2 sigma^2)), shape (taps,).

    x runs over whole pixels, symmetric about zero (thesis, section 4.4.1). The thesis writes a
    minus in front: it convolves, where this is to be multiplied with the picture.
    """
    x = np.arange(taps) - (taps - 1) / 2
    kernel: FloatArray = x / (sigma**3 * math.sqrt(2 * math.pi)) * np.exp(-(x**2) / (2 * sigma**2))
    return kernel


@compiled
def literal_weights(  # noqa: PLR0917
    pixels: Image,
    states: FloatArray,
    spacing: float,
    kernel: FloatArray,
    epsilon: float,
    smallest: float,
) -> FloatArray:
    """Return |c_l| + |c_r| of each cable whose borders oppose each other, else epsilon; (N,).

    Parameters
    ----------
    pixels, states, spacing, kernel, epsilon
        See `Yardstick`.
    smallest : float
        A sum of responses below this has no sign [grey levels].
    """
    height, width = pixels.shape
    middle_x, middle_y = (width - 1) / 2, (height - 1) / 2
    reach = int(math.hypot(width, height) / 2 / spacing)
    half = (len(kernel) - 1) / 2
    weights = np.empty(len(states))
    sums = np.zeros(2)
    for particle in range(len(states)):
        distance, angle = states[particle, 0], states[particle, 1]
        half_width, skew = states[particle, 2] / 2, states[particle, 3]
        for border in range(2):
            side = 2.0 * border - 1.0
            cos, sin = math.cos(angle + side * skew), math.sin(angle + side * skew)
            offset = (distance + side * half_width) * math.cos(skew)
            total = 0.0
            for step in range(-reach, reach + 1):
                x = offset * cos - step * spacing * sin
                y = offset * sin + step * spacing * cos
                if abs(x) > middle_x or abs(y) > middle_y:
                    continue
                for tap in range(len(kernel)):
                    # Rows run down where y runs up; beyond the edge its outermost pixels go on.
                    column = min(max(middle_x + x + (tap - half) * cos, 0.0), width - 1.0)
                    row = min(max(middle_y - y - (tap - half) * sin, 0.0), height - 1.0)
                    left, top = min(int(column), width - 2), min(int(row), height - 2)
                    along, down = column - left, row - top
                    upper = pixels[top, left] * (1 - along) + pixels[top, left + 1] * along
                    lower = pixels[top + 1, left] * (1 - along) + pixels[top + 1, left + 1] * along
                    total += (upper * (1 - down) + lower * down) * kernel[tap]
            sums[border] = total
        left_sum, right_sum = sums[0], sums[1]
        weights[particle] = epsilon
        if left_sum * right_sum < 0.0 and min(abs(left_sum), abs(right_sum)) > smallest:
            weights[particle] = max(abs(left_sum) + abs(right_sum), epsilon)
    return weights
