"""Appearance of a target and its surroundings: histograms, learnt at the start and adapted.

Each pixel has one number for the bin of its colour, or of its grey and texture.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray, shares_of
from cable_tracker.compilation import compiled
from cable_tracker.tracking.image_frame import Window, bounding_box

COLOUR_BINS = (8, 16, 16)
"""Numbers of bins of luma and the two chromas."""

GREY_BINS = (24, 8, 1)
"""Numbers of bins of luma and texture, and one."""

OUTERMOST = 0.5
"""Percentage of the pixels below the lowest and above the highest bin's middle range."""

UNSEEN = 0.01
"""Share of the target's histogram that is spread over all bins."""

UNSEEN_AROUND = 0.3
"""The same of the surroundings: a colour that neither has shown is rather another's."""

NEAR_REACH, LEAST_NEAR_REACH = 0.75, 4
"""Reach of what is near a target beyond its box: this share of the box's side, and as many pixels
more."""

NEAR_SHARE = 0.5
"""Share of the surroundings' histogram that comes from near the target."""

LEAST_LIKENESS = 0.5
"""Least likeness of the greys of pixels that resemble the target."""


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


@dataclass(frozen=True, slots=True, eq=False)
class Appearance:
    """Histograms of target and surroundings, with likelihood ratios and likeness.

    Attributes
    ----------
    bins : Bins
        Bins of pixels.
    first : FloatArray
        Histogram of the target at the start: shares of the bins, shape (B,), summing to one.
    target, surroundings : FloatArray
        Present histograms of target and surroundings, shape (B,), each summing to one.
    """

    bins: Bins
    first: FloatArray
    target: FloatArray
    surroundings: FloatArray

    def log_ratios(self, limit: float, first_share: float = 0.0) -> NDArray[np.float32]:
        """Return log p(bin | target) / p(bin | surroundings), shape (B,).

        At most `limit`, of either sign; `first_share` of the target's histogram is that of the
        start.
        """
        shape = self.bins.shape
        target, surroundings = (
            _smoothed(each, shape) for each in (self._mixed(first_share), self.surroundings)
        )
        even = 1.0 / self.bins.count
        own = (1.0 - UNSEEN) * target + UNSEEN * even
        others = (1.0 - UNSEEN_AROUND) * surroundings + UNSEEN_AROUND * even
        ratios = np.log(own / others)
        return np.clip(ratios, -limit, limit).astype(np.float32)

    def hue_roots(self, first_share: float = 0.0) -> FloatArray:
        """Return the roots of the target's shares of the hues, shape (K,)."""
        roots: FloatArray = np.sqrt(_hues(self._mixed(first_share), self.bins.shape))
        return roots

    def likeness(self, histogram: FloatArray, first_share: float = 0.0) -> float:
        """Return the Bhattacharyya coefficient of a region's histogram and the target's, 0 to 1."""
        target, other = (
            _hues(each, self.bins.shape) for each in (self._mixed(first_share), histogram)
        )
        return float(np.sqrt(target * other).sum())

    def resembles_target(self, greys: NDArray[np.uint8]) -> bool:
        """Return whether pixels (K,) resemble the target by their grey alone, not its surroundings.

        Frames in colour and in grey have that in common.
        """
        count = self.bins.shape[0]
        numbers = self.bins.lookups[0, greys] // (self.bins.count // count)
        shown = np.bincount(numbers, minlength=count) / max(len(greys), 1)
        target, surroundings = (
            np.sqrt(_lumas(each, self.bins.shape) * _smoothed(shown, (count, 1, 1))).sum()
            for each in (self.target, self.surroundings)
        )
        return bool(target > max(surroundings, LEAST_LIKENESS))

    def _mixed(self, first_share: float) -> FloatArray:
        """Return the target's histogram with a share of that of the start, shape (B,)."""
        return first_share * self.first + (1.0 - first_share) * self.target

    def adapted(
        self, target: FloatArray, surroundings: FloatArray, rate: float, outer_rate: float
    ) -> Appearance:
        """Return the appearance moved towards histograms of a new frame, by two rates."""
        return replace(
            self,
            target=(1.0 - rate) * self.target + rate * target,
            surroundings=(1.0 - outer_rate) * self.surroundings + outer_rate * surroundings,
        )


def _hues(histogram: FloatArray, shape: tuple[int, int, int]) -> FloatArray:
    """Return the chroma histogram summed over luma (luma depends on distance), smoothed twice.

    Of a grey picture, the histogram of all bins, smoothed once.
    """
    if shape[2] == 1:
        return _smoothed(histogram, shape)
    chromas = (1, shape[1], shape[2])
    hues = histogram.reshape(shape).sum(axis=0)
    return _smoothed(_smoothed(hues, chromas), chromas)


def _lumas(histogram: FloatArray, shape: tuple[int, int, int]) -> FloatArray:
    """Return the histogram of the first channel alone, smoothed once."""
    lumas = histogram.reshape(shape).sum(axis=(1, 2))
    return _smoothed(lumas, (shape[0], 1, 1))


def _smoothed(histogram: FloatArray, shape: tuple[int, int, int]) -> FloatArray:
    """Spread every bin a little over its neighbours."""
    smooth = np.ascontiguousarray(histogram, dtype=np.float64).reshape(-1)
    for axis in range(3):
        if shape[axis] > 1:
            after = shape[1] * shape[2] if axis == 0 else shape[2] if axis == 1 else 1
            smooth = _smoothed_along(smooth, shape[axis], after)
    return smooth


@compiled
def _smoothed_along(values: FloatArray, count: int, stride: int) -> FloatArray:
    """Weigh neighbours along an axis of `count` bins, `stride` apart, by 1/4, 1/2, 1/4."""
    result = np.empty_like(values)
    for block in range(0, len(values), count * stride):
        for place in range(count):
            first = block + place * stride
            back = stride if place > 0 else 0
            forth = stride if place < count - 1 else 0
            for index in range(first, first + stride):
                before, after = values[index - back], values[index + forth]
                result[index] = 0.25 * before + 0.5 * values[index] + 0.25 * after
    return result


def window_near(mask: BoolArray) -> Window:
    """Return the window of what is near a mask (H, W); an empty window for an empty mask."""
    box = bounding_box(mask)
    if box is None:
        return 0, 0, 0, 0
    left, top, right, bottom = box
    reach_x = int(NEAR_REACH * (right - left)) + LEAST_NEAR_REACH
    reach_y = int(NEAR_REACH * (bottom - top)) + LEAST_NEAR_REACH
    return (
        max(left - reach_x, 0), max(top - reach_y, 0),
        min(right + reach_x, mask.shape[1]), min(bottom + reach_y, mask.shape[0]),
    )  # fmt: skip


def learn_appearance(bin_map: BinMap, mask: BoolArray, bins: Bins) -> Appearance:
    """Return the appearance of a target and its surroundings, from a single frame.

    Parameters
    ----------
    bin_map : BinMap
        Bins of the frame's pixels.
    mask : BoolArray
        The target, of the same shape.
    bins : Bins
        What made the bins.
    """
    target, surroundings = learn_histograms(bin_map, mask, bins.count)
    return Appearance(bins, target, target, surroundings)


def learn_histograms(bins: BinMap, mask: BoolArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Return the histograms of a target and of its surroundings.

    Parameters
    ----------
    bins : BinMap
        Bins of the frame's pixels.
    mask : BoolArray
        The target, of the same shape.
    count : int
        Number of bins.

    Returns
    -------
    (FloatArray, FloatArray)
        Shares, shape (B,); all even where there are no pixels.
    """
    target, beside, far = _counted(bins, mask, np.array(window_near(mask)), count)
    around = NEAR_SHARE * shares_of(beside) + (1.0 - NEAR_SHARE) * shares_of(far)
    return shares_of(target), around


@compiled
def _counted(
    bins: BinMap, mask: BoolArray, near: NDArray[np.int64], count: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    height, width = bins.shape
    target, beside, far = np.zeros(count), np.zeros(count), np.zeros(count)
    left, top, right, bottom = near[0], near[1], near[2], near[3]
    for row in range(height):
        for column in range(width):
            if mask[row, column]:
                target[bins[row, column]] += 1.0
            elif top <= row < bottom and left <= column < right:
                beside[bins[row, column]] += 1.0
            elif row % 2 == 0 and column % 2 == 0:
                far[bins[row, column]] += 1.0
    return target, beside, far
