"""Cells of cable-like texture, and the cable that fits them.

References
----------
A. Grau, J. Climent and J. Aranda (1998), "Real-time architecture for cable tracking using texture
descriptors": five descriptors of the contours in a cell (straightness, abruptness, discontinuity,
granularity, blurriness) tell the cable from the sea bed.

The descriptors are defined here by their meaning: `describe_cells` says how. A logistic score tells
cells on the border of a cable from the rest of the bottom, for a cable's skin has no texture that
is its own. Every such cell stands for the piece of contour in it: one point with a direction. The
borders are lines through these points, and the centreline runs between them.

The constants and the weights of the score were fitted to simulated dives of the seeds 100 to 109.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.detection.baselines.hough import hough_lines
from cable_tracker.detection.border_lines import (
    CONTRAST_CAP,
    BorderLines,
    EdgePoints,
    gradient_of,
    gradient_ridge,
    magnitude,
)
from cable_tracker.detection.detector import CableDetector
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.tracking.image_frame import pixel_to_image
from cable_tracker.tracking.parameter_table import pixel_scale

SIGMA = 1.0
"""Sigma of the smoothing before the gradient is taken [px]."""

CELL = 13
"""Side of a cell [px at the reference width]; odd, so that it has a middle."""

SMALLEST_CELL = 7

STRIDE = 4
"""Distance of the middles of neighbouring cells, which overlap [px]."""

EDGE_CONTRAST = 2.0
"""Contours are ridges of the gradient with more contrast than this [frame's scale]."""

LITTLE = 0.05
"""Weight of "no contour here" in the mean over a cell, so that few pixels count little."""

GRAIN_SIGMA = 1.5
"""Sigma of the smoothing before grains are counted [px]."""

GRAIN_SIDE = 5
"""A grain is brighter or darker than all in a square of this side about it [px]."""

WEIGHTS = np.array([3.68, -13.0, -2.36, -0.2, -21.96])
"""Weights of straightness, abruptness, discontinuity, granularity, blurriness."""

BIAS = 3.15

MINIMUM_PROBABILITY = 0.25
"""Cells that are less probably cable do not count."""


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Overlapping cells of a picture that hold some contour.

    Attributes
    ----------
    descriptors : FloatArray
        Straightness, abruptness, discontinuity, granularity, blurriness; shape (K, 5).
    positions : FloatArray
        Middle of the contours in the cell, in the image frame [px], shape (K, 2).
    directions : FloatArray
        Direction of the gradient across these contours [rad], shape (K,).
    """

    descriptors: FloatArray
    positions: FloatArray
    directions: FloatArray


class TextureDetector(CableDetector):
    """Detect cables by the texture of cells; see the module."""

    minimum_score = 0.12

    def _lines(self, pixels: Image, region: SearchRegion | None) -> BorderLines:
        points = cable_cells(describe_cells(pixels)).within(region)
        return hough_lines(points, (pixels.shape[1], pixels.shape[0]))


def cable_cells(cells: Cells) -> EdgePoints:
    """Return the cells on the border of a cable, each as a point.

    The contrast of a point grows with the probability that it is one.
    """
    scores = cells.descriptors @ WEIGHTS + BIAS
    probabilities = 1.0 / (1.0 + np.exp(-np.clip(scores, -50.0, 50.0)))
    points = EdgePoints(cells.positions, cells.directions, CONTRAST_CAP * probabilities)
    return points.selected(probabilities >= MINIMUM_PROBABILITY)


def describe_cells(pixels: Image) -> Cells:
    """Describe the texture of each cell that holds contours.

    * Straightness: length of the mean of the contours' double-angle directions; 1 if all are
      parallel.
    * Abruptness: how much the direction turns between a contour's pixel and its neighbours.
    * Discontinuity: share of the contours' pixels where a contour ends.
    * Granularity: local extremes of brightness, per hundred pixels.
    * Blurriness: 1 / (1 + mean contrast of the contours).

    Parameters
    ----------
    pixels : Image
        Grey levels, float32, shape (h, w).
    """
    smooth = cv2.GaussianBlur(pixels, (0, 0), SIGMA)
    gradient = gradient_of(smooth)
    contrast = np.minimum(gradient.modulus / np.float32(gradient.scale), np.float32(CONTRAST_CAP))
    edge = gradient_ridge(gradient) & (contrast > EDGE_CONTRAST)
    weight = np.where(edge, contrast, np.float32(0))
    length = np.maximum(gradient.modulus, np.float32(1e-6))
    cos, sin = gradient.x / length, gradient.y / length
    cos_double, sin_double = weight * (cos * cos - sin * sin), weight * (2 * cos * sin)
    return _average(
        _CellMaps(
            weight=weight,
            edge=edge.astype(np.float32),
            cos_double=cos_double,
            sin_double=sin_double,
            turn=_turns(weight, cos_double, sin_double),
            ends=_ends(edge.astype(np.float32)),
            grains=_grains(smooth),
            cos=weight * cos,
            sin=weight * sin,
        )
    )


@dataclass(frozen=True, slots=True, eq=False)
class _CellMaps:
    """What is averaged over the cells; each float32 of shape (h, w)."""

    weight: Image
    edge: Image
    cos_double: Image
    sin_double: Image
    turn: Image
    ends: Image
    grains: Image
    cos: Image
    sin: Image


def _turns(weight: Image, cos_double: Image, sin_double: Image) -> Image:
    """Return the deviation of contour pixels from their neighbours' direction, times its weight."""
    near = (3, 3)
    total, cos, sin = (cv2.blur(values, near) for values in (weight, cos_double, sin_double))
    turns: Image = np.where(weight > 0, weight * (1 - magnitude(cos, sin) / (total + 1e-6)), 0)
    return turns.astype(np.float32)


def _ends(edge: Image) -> Image:
    """Return 1 where a contour's pixel has at most one neighbour on the contour."""
    neighbours = cv2.boxFilter(edge, cv2.CV_32F, (3, 3), normalize=False) - edge
    return ((edge > 0) & (neighbours < 1.5)).astype(np.float32)


def _grains(smooth: Image) -> Image:
    """Return 1 at local extremes of brightness."""
    coarse = cv2.GaussianBlur(smooth, (0, 0), GRAIN_SIGMA)
    square = np.ones((GRAIN_SIDE, GRAIN_SIDE), np.uint8)
    highest, lowest = cv2.dilate(coarse, square), cv2.erode(coarse, square)
    # Where all is flat, every pixel is the highest; that is no grain.
    grain = ((coarse >= highest) | (coarse <= lowest)) & (highest - lowest > 1e-3)
    return grain.astype(np.float32)


def _average(maps: _CellMaps) -> Cells:
    height, width = maps.weight.shape
    side = 2 * (max(round(CELL * pixel_scale(width)), SMALLEST_CELL) // 2) + 1

    def mean(values: Image) -> FloatArray:
        averaged = cv2.blur(values, (side, side), borderType=cv2.BORDER_CONSTANT)
        return averaged[STRIDE // 2 :: STRIDE, STRIDE // 2 :: STRIDE].astype(np.float64)

    columns = np.arange(width, dtype=np.float32)[None, :]
    rows = np.arange(height, dtype=np.float32)[:, None]
    weight, edge = mean(maps.weight), mean(maps.edge)
    straightness = np.hypot(mean(maps.cos_double), mean(maps.sin_double)) / (weight + LITTLE)
    abruptness = mean(maps.turn) / (weight + LITTLE)
    discontinuity = mean(maps.ends) / (edge + LITTLE)
    granularity = 100.0 * mean(maps.grains)
    blurriness = 1.0 / (1.0 + weight / (edge + LITTLE))
    filled = edge > 0.5 / side**2
    # The border is the strongest contour of its cell: squares let it outweigh what lies beside it.
    square = maps.weight**2
    total = mean(square)[filled]
    centres = np.stack((mean(square * columns)[filled], mean(square * rows)[filled]), axis=1)
    return Cells(
        descriptors=np.stack(
            [
                values[filled]
                for values in (straightness, abruptness, discontinuity, granularity, blurriness)
            ],
            axis=1,
        ),
        positions=pixel_to_image(centres / total[:, None], (width, height)),
        directions=np.arctan2(mean(maps.sin)[filled], mean(maps.cos)[filled]),
    )
