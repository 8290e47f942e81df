"""Features of pixels: one number for the bin of colour, or of grey and texture."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import Image
from cable_tracker.compilation import compiled

COLOUR_BINS = (8, 16, 16)
"""Numbers of bins of luma and the two chromas."""

GREY_BINS = (24, 8, 1)
"""Numbers of bins of luma and texture, and one."""

OUTERMOST = 0.5
"""Percentage of the pixels below the lowest and above the highest bin's middle range."""

TEXTURE_WINDOW = 5
"""Side of the square over which gradients are averaged [px]."""

BinMap = NDArray[np.uint16]
"""Bin of every pixel, shape (H, W)."""


@dataclass(frozen=True, slots=True, eq=False)
class Bins:
    """How the values of three channels become one bin.

    Attributes
    ----------
    lookups : array
        Summand of each value of each channel in the number of the bin, uint16, shape (3, 256).
    shape : (int, int, int)
        Bins of each channel.
    """

    lookups: NDArray[np.uint16]
    shape: tuple[int, int, int]

    @property
    def count(self) -> int:
        """Number of bins."""
        return self.shape[0] * self.shape[1] * self.shape[2]


def channels_of(image: Image) -> NDArray[np.uint8]:
    """Return three channels of a picture, uint8, shape (H, W, 3).

    Of a coloured one (H, W, 3), blue-green-red: luma and two chromas; of a grey one (H, W): grey,
    texture, and nothing.
    """
    smooth = cv2.blur(image, (3, 3))
    if image.ndim == 3:
        return np.asarray(cv2.cvtColor(smooth, cv2.COLOR_BGR2YCrCb), dtype=np.uint8)
    across, down = cv2.spatialGradient(smooth)
    gradient = cv2.add(cv2.convertScaleAbs(across), cv2.convertScaleAbs(down))
    texture = cv2.blur(gradient, (TEXTURE_WINDOW, TEXTURE_WINDOW))
    # The root spreads the many small gradients over more bins than the few large ones.
    rooted = cv2.LUT(texture, np.round(np.sqrt(np.arange(256) * 255.0)).astype(np.uint8))
    return np.asarray(cv2.merge((smooth, rooted, np.zeros_like(smooth))), dtype=np.uint8)


def choose_bins(channels: NDArray[np.uint8], is_coloured: bool) -> Bins:
    """Spread the bins over the values that a frame holds."""
    shape = COLOUR_BINS if is_coloured else GREY_BINS
    lookups = np.zeros((3, 256), np.uint16)
    step = 1
    for channel in (2, 1, 0):
        count = shape[channel]
        low, high = np.percentile(channels[::2, ::2, channel], (OUTERMOST, 100.0 - OUTERMOST))
        width = max(high - low, count / 2.0) * 1.2 / count
        middle = (low + high) / 2.0
        numbers = np.floor((np.arange(256) - middle) / width + count / 2.0)
        lookups[channel] = np.clip(numbers, 0, count - 1) * step
        step *= count
    return Bins(lookups, shape)


@compiled
def bins_of(channels: NDArray[np.uint8], lookups: NDArray[np.uint16]) -> BinMap:
    """Return the bin of every pixel."""
    height, width = channels.shape[:2]
    result = np.empty((height, width), np.uint16)
    for row in range(height):
        for column in range(width):
            result[row, column] = (
                lookups[0, channels[row, column, 0]]
                + lookups[1, channels[row, column, 1]]
                + lookups[2, channels[row, column, 2]]
            )
    return result


@compiled
def looked_up(bins: BinMap, table: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the value of every pixel's bin, shape (H, W)."""
    height, width = bins.shape
    result = np.empty((height, width), np.float32)
    for row in range(height):
        for column in range(width):
            result[row, column] = table[bins[row, column]]
    return result
