"""Lines of a Hough transform over the zero crossings of a Laplacian of Gaussian.

References
----------
S. Matsumoto and Y. Ito (1995), "Real-time vision-based tracking of submarine-cables for AUV/ROV":
edges by a Laplacian of Gaussian, lines by a Hough transform, limited to a region around the last
result. B. A. A. P. Balasuriya, M. Takai, W. C. Lam, T. Ura and Y. Kuroda (1997), "Vision based
autonomous underwater vehicle navigation: underwater cable tracking": the same with a region of
interest that follows a prediction.

A vote is cast only near the gradient's own direction, over the full turn, so that dark-to-bright
and bright-to-dark borders are kept apart from the beginning.

The constants were chosen on simulated dives of the seeds 100 to 109.
"""

from __future__ import annotations

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image
from cable_tracker.compilation import compiled
from cable_tracker.detection.border_lines import (
    BorderLines,
    EdgePoints,
    Gradient,
    fit_lines,
    gradient_of,
)
from cable_tracker.detection.detector import CableDetector
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.tracking.image_frame import pixel_to_image
from cable_tracker.tracking.parameter_table import pixel_scale

SIGMA = 2.0
"""Sigma of the Laplacian of Gaussian [px at the reference width]."""

SMALLEST_SIGMA = 1.0

EDGE_CONTRAST = 2.0
"""Zero crossings with less contrast are no edges [frame's scale]."""

ANGLE_BINS = 180
"""Bins of the accumulator over a full turn."""

OFFSET_BIN = 2.0
"""Width of a bin of the accumulator [px at the reference width]."""

VOTE_SPREAD = 2
"""Bins to either side of the gradient's direction that a point votes for."""

MOST_LINES = 24
VOTE_CAP = 6.0


class HoughDetector(CableDetector):
    """Detect cables by edges and a Hough transform; see the module."""

    minimum_score = 0.35

    def _lines(self, pixels: Image, region: SearchRegion | None) -> BorderLines:
        points = zero_crossings(pixels).within(region)
        return hough_lines(points, (pixels.shape[1], pixels.shape[0]))


def zero_crossings(pixels: Image) -> EdgePoints:
    """Return the zero crossings of the Laplacian of Gaussian where the gradient is strong.

    Parameters
    ----------
    pixels : Image
        Grey levels, float32, shape (h, w).
    """
    sigma = max(SIGMA * pixel_scale(pixels.shape[1]), SMALLEST_SIGMA)
    smooth = cv2.GaussianBlur(pixels, (0, 0), sigma)
    laplacian = cv2.Laplacian(smooth, cv2.CV_32F, ksize=3)
    gradient = gradient_of(smooth)
    strong = gradient.modulus > EDGE_CONTRAST * gradient.scale
    across = _crossings_between(laplacian, strong, gradient, (0, 1))
    down = _crossings_between(laplacian, strong, gradient, (1, 0))
    return EdgePoints(
        np.concatenate((across.positions, down.positions)),
        np.concatenate((across.directions, down.directions)),
        np.concatenate((across.contrasts, down.contrasts)),
    )


def _crossings_between(
    laplacian: Image, strong: BoolArray, gradient: Gradient, step: tuple[int, int]
) -> EdgePoints:
    """Return the crossings between each pixel and its neighbour one step further."""
    height, width = laplacian.shape
    here = np.s_[: height - step[0], : width - step[1]]
    there = np.s_[step[0] :, step[1] :]
    signs = laplacian < 0
    rows, columns = np.nonzero((signs[here] != signs[there]) & strong[here] & strong[there])
    before = laplacian[rows, columns].astype(np.float64)
    after = laplacian[rows + step[0], columns + step[1]].astype(np.float64)
    part = before / (before - after)
    pixels = np.stack((columns + step[1] * part, rows + step[0] * part), axis=1)
    return EdgePoints(
        positions=pixel_to_image(pixels, (width, height)),
        directions=np.arctan2(gradient.y[rows, columns], gradient.x[rows, columns]).astype(
            np.float64
        ),
        contrasts=gradient.modulus[rows, columns].astype(np.float64) / gradient.scale,
    )


def hough_lines(points: EdgePoints, image_size: tuple[int, int]) -> BorderLines:
    """Return the strongest lines through edges in a picture of this size [px]."""
    angles, offsets = hough_peaks(points, image_size)
    return fit_lines(angles, offsets, points, image_size)


def hough_peaks(points: EdgePoints, image_size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Return normal angles [rad] and offsets [px] of the strongest lines, best first.

    Parameters
    ----------
    points : EdgePoints
        The edges.
    image_size : (int, int)
        Width and height of the picture [px].
    """
    offset_bin = max(OFFSET_BIN * pixel_scale(image_size[0]), 1.0)
    reach = int(np.hypot(*image_size) / 2 / offset_bin) + 1
    weights = np.minimum(points.contrasts, VOTE_CAP)
    votes = _vote(points.positions, points.directions, weights, offset_bin, reach)
    # The angle goes round: a margin of the other end lets peaks at the seam be seen whole.
    margin = 2
    padded = np.pad(votes, ((margin, margin), (0, 0)), mode="wrap").astype(np.float32)
    smooth = cv2.GaussianBlur(padded, (3, 3), 0)
    highest = cv2.dilate(smooth, np.ones((5, 3), np.uint8))
    peaks = (smooth >= highest)[margin:-margin] & (smooth[margin:-margin] > 0)
    rows, columns = np.nonzero(peaks)
    order = np.argsort(-smooth[margin:-margin][rows, columns], kind="stable")[:MOST_LINES]
    angles = rows[order].astype(np.float64) * (2 * np.pi / ANGLE_BINS)
    offsets = (columns[order] - reach).astype(np.float64) * offset_bin
    return angles, offsets


@compiled
def _vote(
    positions: FloatArray,
    directions: FloatArray,
    weights: FloatArray,
    offset_bin: float,
    reach: int,
) -> FloatArray:
    """Return the votes of points (P, 2) for normal angles and offsets, (bins, 2 reach + 1)."""
    votes = np.zeros((ANGLE_BINS, 2 * reach + 1))
    turns = np.arange(ANGLE_BINS) * (2 * np.pi / ANGLE_BINS)
    cosines, sines = np.cos(turns), np.sin(turns)
    for k in range(len(positions)):
        nearest = int(np.rint(directions[k] * (ANGLE_BINS / (2 * np.pi))))
        for spread in range(-VOTE_SPREAD, VOTE_SPREAD + 1):
            row = (nearest + spread) % ANGLE_BINS
            offset = positions[k, 0] * cosines[row] + positions[k, 1] * sines[row]
            column = int(np.rint(offset / offset_bin)) + reach
            votes[row, min(max(column, 0), 2 * reach)] += weights[k]
    return votes
