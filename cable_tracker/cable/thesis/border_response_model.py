"""The observation of the thesis: sums of derivative-of-Gaussian responses along both borders.

The responses are those of the scanned gradients, read where each border crosses the scan lines, and
multiplied by the length of border that a crossing stands for: the sum means the same as that of
points at equal distances along the border.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.borders.border_points import (
    BLOCK,
    MINIMUM_LENGTH,
    border_line,
    find_crossings,
    measure_responses,
    room_for_crossings,
)
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.cable.measure.scanned_gradients import ScanInputs
from cable_tracker.cable.model.geometry import border_side
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import compiled, compiled_inside

SMALLEST_SUM = 1e-3
"""Sums below this are the rounding of float32 pixels [grey levels]."""

LEAST_SCALE = 0.3
"""Smallest robust scale of a frame [grey levels per working px]: below it lies the rounding of
pixels."""


class BorderResponseModel:
    """A cable weighs |c_l| + |c_r| if the sums along its borders have opposite signs.

    Parameters
    ----------
    parameters : TrackerParameters
        `epsilon` is the weight of all others.
    """

    def __init__(self, parameters: TrackerParameters) -> None:
        self._epsilon = parameters.epsilon

    def log_likelihoods(self, states: FloatArray, image: WorkingImage) -> FloatArray:
        """Return the logarithm of each cable's weight, shape (N,), for states (N, 8)."""
        sums, _ = border_sums(states, image)
        return np.log(response_weights(sums, self._epsilon))

    def evidence(self, state: FloatArray, image: WorkingImage) -> float:
        """Return the mean response per point of a cable's weaker border [robust scales].

        Zero when the borders do not oppose each other, or lie outside the image. `state`: (8,).
        """
        sums, lengths = border_sums(state[None, :], image)
        if not opposed(*sums[0]) or lengths.min() < MINIMUM_LENGTH:
            return 0.0
        scale = max(image.scan.gradient_scale, LEAST_SCALE) * image.scale
        return float((np.abs(sums) / lengths).min()) / scale


@compiled
def response_weights(sums: FloatArray, epsilon: float) -> FloatArray:
    """Return the weight of each cable, shape (N,), for sums of responses (N, 2)."""
    weights = np.empty(len(sums))
    for row in range(len(sums)):
        left, right = sums[row]
        strength = max(abs(left) + abs(right), epsilon)
        weights[row] = strength if opposed(left, right) else epsilon
    return weights


@compiled_inside
def opposed(left: float, right: float) -> bool:
    """Tell whether the sums along two borders have opposite signs, as those of a strip.

    A border in a flat part of the image, black or saturated, has no sign.
    """
    return min(abs(left), abs(right)) > SMALLEST_SUM and left * right < 0.0


def border_sums(states: FloatArray, image: WorkingImage) -> tuple[FloatArray, FloatArray]:
    """Return sums of responses [grey levels] and visible lengths, left and right, (N, 2) each.

    A sum is positive where the image brightens along the border's normal; a length is in distances
    of the scan lines.
    """
    sums, lengths = np.empty((len(states), 2)), np.empty((len(states), 2))
    rows = np.array(states, np.float64, order="C")
    _sum_responses(rows, image.scan, sums, lengths)
    # Gradients are in robust scales per working pixel, sums in grey levels per reference pixel.
    return sums * (image.scan.gradient_scale * image.scale), lengths


@compiled
def _sum_responses(
    states: FloatArray, scan: ScanInputs, sums: FloatArray, lengths: FloatArray
) -> None:
    crossings = room_for_crossings()
    for cable in range(len(states)):
        for border in range(2):
            side = border_side(border)
            line = border_line(states[cable], side, scan)
            lines = scan.rows if line.is_steep else scan.columns
            total, count = np.float32(0.0), 0
            for start in range(0, len(lines.places), BLOCK):
                first, found = find_crossings(lines, start, line, crossings)
                measure_responses(lines, first, found, line, crossings)
                for index in range(found):
                    total += crossings.responses[index]
                count += found
            sums[cable, border] = -side * float(total) / abs(line.inward)
            lengths[cable, border] = count / abs(line.inward)
