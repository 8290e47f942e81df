"""Places of a frame where the target may be: peaks of the filtered map of log-ratios."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import FloatArray

COARSENESS = 4
"""Pixels of the working image a pixel of the coarse map."""

SURROUND = 2.0
"""Side of what is around the target against its own."""


SURROUND_WEIGHT = 0.6
"""Factor on the mean log-ratio around the target, which is subtracted from that within."""

ELLIPSE_SIDE = 0.87
"""Side of the box of an ellipse's area, over that of the box about it: about the root of pi/4."""


class MapPeak(NamedTuple):
    """A peak of the filtered map of log-ratios.

    Attributes
    ----------
    x, y : float
        From the image centre, y up [px].
    log_scale : float
        At which it was looked for.
    strength : float
        Mean log-ratio within less that around.
    """

    x: float
    y: float
    log_scale: float
    strength: float


def find_peaks(
    ratios: NDArray[np.float32],
    half_extent: tuple[float, float],
    log_scales: FloatArray,
    count: int,
) -> list[MapPeak]:
    """Return the strongest peaks, at most `count` a scale, strongest first.

    Parameters
    ----------
    ratios : array
        Map of log-ratios, float32, shape (H, W).
    half_extent : (float, float)
        Half width and height of the target at scale 1 [px].
    log_scales : FloatArray
        At which to look, shape (K,).
    count : int
        Peaks for every scale.
    """
    height, width = ratios.shape
    small = (-(-width // COARSENESS), -(-height // COARSENESS))
    coarse = cv2.resize(ratios, small, interpolation=cv2.INTER_AREA)
    peaks = []
    for log_scale in log_scales:
        factor = float(np.exp(log_scale)) * 2.0 / COARSENESS
        # Nothing in view is larger than the picture, whatever is believed of its size.
        sides = [
            min(max(ELLIPSE_SIDE * half * factor, 1.0), float(side))
            for half, side in zip(half_extent, small, strict=True)
        ]
        inner = cv2.boxFilter(coarse, -1, _kernel(sides, 1.0), borderType=cv2.BORDER_REPLICATE)
        outer = cv2.boxFilter(coarse, -1, _kernel(sides, SURROUND), borderType=cv2.BORDER_REPLICATE)
        response = inner - SURROUND_WEIGHT * outer
        reach = [max(int(side / 2), 1) for side in sides]
        for _ in range(count):
            row, column = divmod(int(response.argmax()), small[0])
            strength = float(response[row, column])
            if strength <= 0.0:
                break
            x = (column + 0.5) * width / small[0] - 0.5 - (width - 1) / 2
            y = (height - 1) / 2 - (row + 0.5) * height / small[1] + 0.5
            peaks.append(MapPeak(x, y, float(log_scale), strength))
            response[
                max(row - reach[1], 0) : row + reach[1] + 1,
                max(column - reach[0], 0) : column + reach[0] + 1,
            ] = -np.inf
    return sorted(peaks, key=lambda peak: -peak.strength)


def _kernel(sides: list[float], factor: float) -> tuple[int, int]:
    """Return odd sides near those wanted."""
    return (2 * round((sides[0] * factor - 1) / 2) + 1, 2 * round((sides[1] * factor - 1) / 2) + 1)
