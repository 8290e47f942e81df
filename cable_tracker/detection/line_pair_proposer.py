"""Line pairs of a whole frame, fast enough for every frame of a tracker.

A coarse Hough transform over the gradients that the tracker has worked out anyway. Each strong
gradient votes near its own direction over the full turn, so that the two borders of a cable have
opposite normals. What comes out is a proposal: coarse, often wrong, seldom without the cable.

A faint border is lost among the gradients of the bottom, none of which is strong where it runs;
but along it they all have one sign. So while a cable is searched for, the gradients of a coarse
picture are projected onto each direction and summed along its lines, too (a Radon transform), and a
sum is judged by the root of the sum of its squares: a few strong edges that lie on a line by chance
weigh little against many weak ones that agree. Two pictures are searched: that of the brightness,
and that of the texture, in which a smooth cable on a rough bottom is a dark strip whatever its grey
level.

The constants of strong lines were chosen on simulated dives of the seeds 200 to 203, those of
coherent lines on the simulated worlds to tune on (`tune_*`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.cable.measure.scanned_gradients import ACROSS, ALONG, ScanLines
from cable_tracker.cable.model.state import pose_units
from cable_tracker.compilation import compiled, compiled_inside, compiled_loop, compiled_part
from cable_tracker.detection.border_lines import magnitude, sobel
from cable_tracker.detection.line_pairs import PairLimits, plausible_pairs
from cable_tracker.detection.vote_peaks import (
    ANGLE_BINS,
    BIN,
    DIRECTIONS,
    strongest_lines,
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

STRONG = 2.0
"""Weaker gradients do not vote [robust scales]."""

VOTE_CAP = 5.0
"""No gradient votes with more: a glint must not outweigh a long border [robust scales]."""

OFFSET_BIN = 3.0
"""Width of a bin of the accumulator [px at the reference width]."""

VOTE_SPREAD = 2
"""Bins to either side of the gradient's direction that it votes for."""

MOST_LINES = 24
MOST_CABLES = 8

MOST_FAINT = 4
"""Number of cables between faint lines that are proposed, from brightness, from texture and from
the map each."""

LEAST_MAP_PROBABILITY = 0.2
"""Least probability of a map's highest cell, below which the map is not searched for lines."""


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


class LinePairProposer:
    """Propose cables where two lines of opposite contrast are nearly parallel.

    Parameters
    ----------
    limits : PairLimits
        Widths and skews of the cables that are proposed.
    uses_map : bool
        Whether lines are searched in the map of the frame, too.
    """

    def __init__(self, limits: PairLimits, *, uses_map: bool) -> None:
        self._limits = limits
        self._uses_map = uses_map

    def propose(self, image: WorkingImage, *, is_searching: bool) -> FloatArray:
        """Return d, alpha, w, beta of cables in the frame [px, rad], best first, shape (K, 4).

        Parameters
        ----------
        image : WorkingImage
            The frame.
        is_searching : bool
            Whether it is more likely than not that the tracker follows none: faint lines are
            searched, too, which takes more time.
        """
        votes, offset_bin = accumulated_votes(image)
        found = [self._pairs(votes, offset_bin, image)[:MOST_CABLES]]
        if is_searching:
            found += [
                self._faint_pairs(picture, image)[:MOST_FAINT]
                for picture in self._coarse_pictures(image)
                if min(picture.shape) >= FEWEST_CELLS
            ]
        return np.asarray(np.concatenate(found) * pose_units(1.0 / image.reduction))

    def _coarse_pictures(self, image: WorkingImage) -> Iterator[Image]:
        """Yield the coarse pictures in which faint lines are searched, float32 (m, n)."""
        yield coarse_brightness(image)
        yield coarse_texture(image)
        if (
            self._uses_map
            and image.cable_map.probabilities.max(initial=0.0) >= LEAST_MAP_PROBABILITY
        ):
            yield image.cable_map.probabilities

    def _faint_pairs(self, picture: Image, image: WorkingImage) -> FloatArray:
        """Return the cables between coherent lines of a coarse picture, best first."""
        cell = image.size[0] / picture.shape[1]
        return self._pairs(coherent_votes(picture), cell, image)

    def _pairs(self, votes: Image, offset_bin: float, image: WorkingImage) -> FloatArray:
        """Return the cables between the lines with most votes [working px, rad], best first."""
        angles, offsets, supports = strongest_lines(votes, offset_bin, MOST_LINES)
        width, height = image.size
        poses, scores = plausible_pairs(
            angles, offsets, supports, self._limits, (float(width), float(height))
        )
        return np.asarray(poses[(-scores).argsort(kind="stable")])


class _Accumulator(NamedTuple):
    """Votes by normal and offset; `middle` is the number of the bin of offset zero."""

    votes: Image
    bins_per_pixel: float
    middle: int


def accumulated_votes(image: WorkingImage) -> tuple[Image, float]:
    """Return the votes of a frame's scan lines for normals and offsets.

    Returns
    -------
    votes : Image
        float32, shape (ANGLE_BINS, 2 middle + 1), as `strongest_lines` takes them.
    offset_bin : float
        Width of a bin of offsets [px].
    """
    scan = image.scan
    offset_bin = max(OFFSET_BIN * image.scale, 1.0)
    middle = int(math.hypot(*image.size) / 2 / offset_bin) + 2
    votes = np.zeros((ANGLE_BINS, 2 * middle + 1), np.float32)
    _vote_of_both(scan.rows, scan.columns, _Accumulator(votes, 1.0 / offset_bin, middle))
    return votes, offset_bin


@compiled
def _vote_of_both(rows: ScanLines, columns: ScanLines, accumulator: _Accumulator) -> None:
    _vote(rows, False, accumulator)
    _vote(columns, True, accumulator)


@compiled_part
def _vote(lines: ScanLines, turned: bool, accumulator: _Accumulator) -> None:
    """Let the ridges of the gradient along scan lines vote; `turned` scan lines are columns."""
    places, length = lines.places, lines.gradients.shape[1]
    squares, ridges = np.empty(length, np.float32), np.empty(length, np.int64)
    candidates = np.empty(length, np.uint8)
    for line in range(len(places)):
        values = lines.gradients[line]
        for ridge in range(_find_ridges(values, squares, candidates, ridges)):
            place = ridges[ridge]
            along, across = float(values[place, ALONG]), float(values[place, ACROSS])
            u, v = place - (length - 1) / 2, places[line]
            weight = min(math.sqrt(squares[place]), VOTE_CAP)
            if turned:
                _vote_for_point(v, u, (across, along), weight, accumulator)
            else:
                _vote_for_point(u, v, (along, across), weight, accumulator)


@compiled_loop
def _find_ridges(gradients: Image, squares: Image, candidates: Image, ridges: IndexArray) -> int:
    """Find the local maxima of strong gradients (n, 3) that are rather along a line than across.

    Fills in the squares (n,) and the indices of the maxima, and returns the number of these.
    """
    for place in range(len(squares)):
        along, across = gradients[place, ALONG], gradients[place, ACROSS]
        squares[place] = along * along + across * across
        candidates[place] = np.uint8(abs(along) >= abs(across))
    # Without branches, which could not be predicted, many places are looked at together.
    before, here, after, inner = squares[:-2], squares[1:-1], squares[2:], candidates[1:-1]
    least = np.float32(STRONG * STRONG)
    for place in range(len(here)):
        inner[place] &= np.uint8(here[place] > least)
        inner[place] &= np.uint8(before[place] <= here[place])
        inner[place] &= np.uint8(here[place] > after[place])
    count = 0
    for place in range(len(inner)):
        ridges[count] = place + 1
        count += inner[place]
    return count


@compiled_inside
def _vote_for_point(
    x: float,
    y: float,
    gradient: tuple[float, float],
    weight: float,
    accumulator: _Accumulator,
) -> None:
    """Vote near the gradient's direction (where it gets brighter) for lines through a point."""
    nearest = int(np.rint(math.atan2(gradient[1], gradient[0]) / BIN))
    for angle in range(nearest - VOTE_SPREAD, nearest + VOTE_SPREAD + 1):
        within = angle + ANGLE_BINS if angle < 0 else angle
        offset = x * DIRECTIONS[0, within] + y * DIRECTIONS[1, within]
        column = int(np.rint(offset * accumulator.bins_per_pixel)) + accumulator.middle
        accumulator.votes[within, column] += weight
