"""Segmentation by histograms of grey level and gradient, contours, and parallel pairs.

References
----------
J. Antich and A. Ortiz (2003), "Underwater Cable Tracking by Visual Feedback"; A. Ortiz, M. Simo and
G. Oliver (2002), "A vision system for an underwater cable tracker": a grid divides the picture;
each cell is segmented by the mountains of its two-dimensional histogram of grey level and gradient
modulus; the contours of the regions are cut into straight segments; segments on one line are
grouped, and parallel groups are the cable.

Here the mountains are found by climbing from every bin to its highest neighbour, for all cells at
once, and a contour is cut wherever its direction leaves a sector of the full turn. The constants
were chosen on simulated dives of the seeds 100 to 109.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image, IndexArray
from cable_tracker.detection.baselines.segments import Segments, lines_of_segments
from cable_tracker.detection.border_lines import BorderLines, Gradient, gradient_of, gradient_ridge
from cable_tracker.detection.detector import CableDetector
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.tracking.image_frame import pixel_to_image
from cable_tracker.tracking.parameter_table import pixel_scale

SIGMA = 1.5
"""Sigma of the smoothing before the gradient is taken [px at the reference width]."""

SMALLEST_SIGMA = 0.8

CELL = 40.0
"""Side of a cell of the grid [px at the reference width]."""

SMALLEST_CELL = 8.0

GREY_BINS = 32
GRADIENT_BINS = 8
TOP_GRADIENT = 8.0
"""Gradient modulus at which the bins end [frame's scale]."""

HISTOGRAM_SIGMA = (2.0, 1.0)
"""Sigma of the smoothing of a histogram along grey level and gradient [bins]."""

GREY_MARGIN = 4.0
"""The bins of a cell span at least this to either side of its middle grey level."""

SECTORS = 16
"""Steps of the full turn; a sector is two of them, so that each direction lies in two sectors."""

MINIMUM_CONTRAST = 2.0
SHORTEST = 6.0
"""Shorter segments are left out [px at the reference width]."""

RIDGE_REACH = 5
"""Side of the square about a contour's pixel in which the ridge of the gradient is its own [px]."""

STRAIGHTNESS = 1.2
"""Largest root mean square distance of a contour's points from its segment [px]."""


class SegmentationDetector(CableDetector):
    """Detect cables by segmentation; see the module."""

    minimum_score = 0.2

    def _lines(self, pixels: Image, region: SearchRegion | None) -> BorderLines:
        scale = pixel_scale(pixels.shape[1])
        smooth = cv2.GaussianBlur(pixels, (0, 0), max(SIGMA * scale, SMALLEST_SIGMA))
        gradient = gradient_of(smooth)
        contours = region_contours(smooth, gradient)
        segments = straight_segments(contours, gradient)
        segments = segments.selected(segments.lengths >= SHORTEST * scale)
        return lines_of_segments(segments.within(region), gradient, MINIMUM_CONTRAST)


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Cells of a picture.

    Attributes
    ----------
    rows, columns : IndexArray
        First row and column of each row and column of cells, shape (R,), (C,).
    cells : IndexArray
        Number of the cell of each pixel, shape (h, w).
    """

    rows: IndexArray
    columns: IndexArray
    cells: IndexArray

    @property
    def count(self) -> int:
        """Number of cells."""
        return len(self.rows) * len(self.columns)

    def spread(self, values: FloatArray) -> FloatArray:
        """Give each pixel (h, w) the value of its cell (R, C)."""
        return values.ravel()[self.cells]


def make_grid(shape: tuple[int, ...]) -> Grid:
    """Divide a picture of shape (h, w) into cells as nearly square as can be."""
    height, width = shape
    side = max(CELL * pixel_scale(width), SMALLEST_CELL)
    down, across = max(round(height / side), 1), max(round(width / side), 1)
    rows, columns = np.arange(height) * down // height, np.arange(width) * across // width
    return Grid(
        rows=np.searchsorted(rows, np.arange(down)),
        columns=np.searchsorted(columns, np.arange(across)),
        cells=rows[:, None] * across + columns[None, :],
    )


def region_contours(smooth: Image, gradient: Gradient) -> BoolArray:
    """Return the boundaries of the segmentation's regions, a mask of shape (h, w).

    The borders of the cells themselves are no contours. A wide border is a region of its own with a
    contour to either side: contours are moved to the ridge of the gradient between them.

    Parameters
    ----------
    smooth : Image
        Grey levels, float32, shape (h, w).
    gradient : Gradient
        Its gradient.
    """
    grid = make_grid(smooth.shape)
    regions = _segment(smooth, gradient, grid)
    meet = np.zeros(smooth.shape, dtype=np.uint8)
    for here, there in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1, :], np.s_[1:, :])):
        differ = (regions[here] != regions[there]) & (grid.cells[here] == grid.cells[there])
        meet[here] |= differ
        meet[there] |= differ
    near = cv2.dilate(meet, np.ones((RIDGE_REACH, RIDGE_REACH), np.uint8)).view(np.bool_)
    strong = gradient.modulus > MINIMUM_CONTRAST * gradient.scale
    contours: BoolArray = near & strong & gradient_ridge(gradient)
    return contours


def _segment(smooth: Image, gradient: Gradient, grid: Grid) -> IndexArray:
    """Return the mountain of its cell's histogram that each pixel belongs to, shape (h, w)."""
    bins = _grey_bins(smooth, grid) * GRADIENT_BINS + _gradient_bins(gradient)
    size = GREY_BINS * GRADIENT_BINS
    places = grid.cells * size + bins
    histograms = np.bincount(places.ravel(), minlength=grid.count * size).astype(np.float64)
    smoothed = _smooth_histograms(histograms.reshape(grid.count, GREY_BINS, GRADIENT_BINS))
    return _climb(smoothed).ravel()[places]


def _grey_bins(smooth: Image, grid: Grid) -> IndexArray:
    """Return the bin of each grey level between the extremes of its cell, shape (h, w)."""
    low, high = (
        extreme.reduceat(extreme.reduceat(smooth, grid.rows, axis=0), grid.columns, axis=1)
        for extreme in (np.minimum, np.maximum)
    )
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, GREY_MARGIN)
    share = (smooth - grid.spread(middle - half)) / grid.spread(2 * half)
    bins: IndexArray = np.clip((share * GREY_BINS).astype(np.int64), 0, GREY_BINS - 1)
    return bins


def _gradient_bins(gradient: Gradient) -> IndexArray:
    share = gradient.modulus / np.float32(gradient.scale * TOP_GRADIENT)
    bins: IndexArray = np.minimum((share * GRADIENT_BINS).astype(np.int64), GRADIENT_BINS - 1)
    return bins


def _smooth_histograms(histograms: FloatArray) -> FloatArray:
    """Smooth histograms (cells, grey, gradient) along their two bin axes."""
    smoothed = histograms
    for axis, sigma in zip((1, 2), HISTOGRAM_SIGMA, strict=True):
        size = smoothed.shape[axis]
        distance = np.arange(size)[:, None] - np.arange(size)[None, :]
        kernel = np.exp(-(distance**2) / (2 * sigma**2))
        smoothed = np.moveaxis(np.moveaxis(smoothed, axis, -1) @ kernel, -1, axis)
    return smoothed


def _climb(heights: FloatArray) -> IndexArray:
    """Return the flat index of the summit above each bin (cells, grey, gradient), same shape."""
    index = np.arange(heights.size).reshape(heights.shape)
    padded = np.pad(heights, ((0, 0), (1, 1), (1, 1)), constant_values=-1.0)
    places = np.pad(index, ((0, 0), (1, 1), (1, 1)))
    greys, gradients = heights.shape[1:]
    best, summits = heights.copy(), index.copy()
    for row in range(3):
        for column in range(3):
            window = np.s_[:, row : row + greys, column : column + gradients]
            higher = padded[window] > best
            best[higher] = padded[window][higher]
            summits[higher] = places[window][higher]
    flat = summits.ravel()
    while True:
        further = flat[flat]
        if np.array_equal(further, flat):
            return flat.reshape(heights.shape)
        flat = further


def straight_segments(contours: BoolArray, gradient: Gradient) -> Segments:
    """Cut contours into straight segments, and fit each by its moments.

    A piece of contour is what hangs together with gradients in one sector of the full turn. The
    sectors overlap by half, so that no direction lies at an edge of both of its sectors; the lines
    that segments are grouped to take such doubles for one.
    """
    rows, columns = np.nonzero(contours)
    directions = np.arctan2(gradient.y[rows, columns], gradient.x[rows, columns])
    steps = np.mod(np.floor(directions * (SECTORS / (2 * np.pi))).astype(np.int64), SECTORS)
    pieces = []
    for first in range(SECTORS):
        chosen = np.mod(steps - first, SECTORS) < 2
        pieces.append(_pieces(rows[chosen], columns[chosen], contours.shape))
    return Segments(
        np.concatenate([piece.starts for piece in pieces]),
        np.concatenate([piece.ends for piece in pieces]),
    )


def _pieces(rows: IndexArray, columns: IndexArray, shape: tuple[int, ...]) -> Segments:
    """Fit a segment to each connected group of pixels that is straight."""
    height, width = shape
    mask = np.zeros((height, width), dtype=np.uint8)
    mask[rows, columns] = 1
    count, labels = cv2.connectedComponents(mask, connectivity=8)
    owner = labels[rows, columns]
    points = pixel_to_image(np.stack((columns, rows), axis=1).astype(np.float64), (width, height))
    x, y = points[:, 0], points[:, 1]
    total = np.maximum(np.bincount(owner, minlength=count), 1)
    mean_x, mean_y, xx, xy, yy = (
        np.bincount(owner, values, count) / total for values in (x, y, x * x, x * y, y * y)
    )
    xx, xy, yy = xx - mean_x**2, xy - mean_x * mean_y, yy - mean_y**2
    angles = 0.5 * np.arctan2(2 * xy, xx - yy)
    spread = np.hypot((xx - yy) / 2, xy)
    across, along = np.maximum((xx + yy) / 2 - spread, 0), (xx + yy) / 2 + spread
    # Points spread evenly over a length L have the variance L^2 / 12.
    half = np.sqrt(12 * along)[:, None] / 2 * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    middles = np.stack((mean_x, mean_y), axis=1)
    straight = np.sqrt(across) <= STRAIGHTNESS
    straight[0] = False
    return Segments((middles - half)[straight], (middles + half)[straight])
