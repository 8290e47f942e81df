"""Edges of a picture, and straight lines through them: candidates for the borders of a cable.

Edges are points with a direction. A border is written with its normal pointing to the brighter
side, so that the two borders of a strip have opposite normals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image, IndexArray
from cable_tracker.cable.model.geometry import Number, lengths_inside
from cable_tracker.compilation import compiled, compiled_inside, compiled_loop
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.tracking.parameter_table import pixel_scale
from cable_tracker.tracking.robust import RAYLEIGH_MEDIAN

GRADIENT_FLOOR = 0.5
"""Smallest robust scale of a frame's gradient [grey levels per px]: below it lies the noise."""

FIT_TOLERANCES = (4.0, 2.5, 2.0)
"""Largest distance of a point from its line, in successive fits [px at the reference width]."""

LEAST_COSINE = math.cos(math.radians(20.0))
"""Cosine of the largest angle (20 deg) between a point's gradient and the line normal."""

MINIMUM_POINTS = 6
"""A line through fewer points is none."""

CONTRAST_CAP = 6.0
"""Contrast above which an edge counts no more: a lamp's glint must not outweigh a long border."""

COVERED_STEP = 4.0
"""Length of the steps along a line that are covered or not [px at the reference width]."""

SAME_OFFSET = 4.0
SAME_ANGLE = float(np.deg2rad(4.0))
"""Lines as close as this are one [px at the reference width, rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class Gradient:
    """The gradient of a smoothed picture, y up.

    Attributes
    ----------
    x, y : Image
        Components [grey levels per px], float32, shape (h, w).
    modulus : Image
        Length of the gradient, float32, shape (h, w).
    scale : float
        Robust standard deviation of x and y over the picture, at least `GRADIENT_FLOOR`. A cable
        covers too little of the picture to move the median.
    """

    x: Image
    y: Image
    modulus: Image
    scale: float


def magnitude(x: Image, y: Image) -> Image:
    """Return the lengths of vectors with components of shape (h, w), float32.

    The last bit of what OpenCV returns depends on where the data lie in memory.
    """
    return np.asarray(np.sqrt(x * x + y * y))


def sobel(picture: Image, scale: float = 1.0) -> tuple[Image, Image]:
    """Return the sums of a Sobel filter to the right and upwards, float32, shapes (h, w).

    `scale` is a factor on them; with 1/8 they are the gradient [grey levels per px].
    """
    x = cv2.Sobel(picture, cv2.CV_32F, 1, 0, ksize=3, scale=scale)
    y = cv2.Sobel(picture, cv2.CV_32F, 0, 1, ksize=3, scale=-scale)
    return np.asarray(x), np.asarray(y)


def gradient_of(smooth: Image) -> Gradient:
    """Return the gradient of a picture that is smoothed already, float32 of shape (h, w)."""
    x, y = sobel(smooth, 1 / 8)
    modulus = magnitude(x, y)
    # Every second row and column gives the same in a quarter of the time.
    scale = float(np.median(modulus[::2, ::2])) / RAYLEIGH_MEDIAN
    return Gradient(x, y, modulus, max(scale, GRADIENT_FLOOR))


def gradient_ridge(gradient: Gradient) -> BoolArray:
    """Return the local maxima of the modulus along the gradient's direction, a mask (h, w)."""
    modulus = gradient.modulus
    upright = np.abs(gradient.x) >= np.abs(gradient.y)
    high_across = modulus >= cv2.dilate(modulus, np.ones((1, 3), np.uint8))
    high_down = modulus >= cv2.dilate(modulus, np.ones((3, 1), np.uint8))
    ridge: BoolArray = np.where(upright, high_across, high_down)
    return ridge


@dataclass(frozen=True, slots=True, eq=False)
class EdgePoints:
    """P points on edges.

    Attributes
    ----------
    positions : FloatArray
        x, y in the image frame [px], shape (P, 2).
    directions : FloatArray
        Direction of the gradient [rad], counter-clockwise from +x, (-pi, pi], shape (P,).
    contrasts : FloatArray
        Modulus of the gradient over the frame's scale, shape (P,).
    """

    positions: FloatArray
    directions: FloatArray
    contrasts: FloatArray

    def __len__(self) -> int:
        return len(self.directions)

    def selected(self, chosen: BoolArray) -> EdgePoints:
        """Return the points of a mask of shape (P,)."""
        return EdgePoints(self.positions[chosen], self.directions[chosen], self.contrasts[chosen])

    def within(self, region: SearchRegion | None) -> EdgePoints:
        """Return the points that a region covers; all of them without a region."""
        return self if region is None else self.selected(region.covers(self.positions))


@dataclass(frozen=True, slots=True, eq=False)
class BorderLines:
    """N lines in Hesse normal form, the normal pointing to the brighter side.

    Attributes
    ----------
    angles : FloatArray
        Normal angles [rad], shape (N,), any turn.
    offsets : FloatArray
        Signed distances from the image centre [px], shape (N,).
    supports : FloatArray
        Share of the line that the picture shows, from 0 to 1, shape (N,).
    """

    angles: FloatArray
    offsets: FloatArray
    supports: FloatArray

    def __len__(self) -> int:
        return len(self.angles)

    def taken(self, chosen: IndexArray) -> BorderLines:
        """Return the lines with these indices, in this order."""
        return BorderLines(self.angles[chosen], self.offsets[chosen], self.supports[chosen])


@compiled_inside
def turn_between(angle: Number, reference: Number) -> Number:
    """Return the turn from a reference to an angle, in [-pi, pi) [rad]."""
    turn: Number = (angle - reference + math.pi) % (2 * math.pi) - math.pi
    return turn


def fit_lines(
    angles: FloatArray, offsets: FloatArray, points: EdgePoints, image_size: tuple[int, int]
) -> BorderLines:
    """Fit lines to the edge points about them, and merge those that become the same.

    Parameters
    ----------
    angles, offsets : FloatArray
        First guesses [rad, px], shape (N,).
    points : EdgePoints
        The edges of the picture.
    image_size : (int, int)
        Width and height of the picture [px].

    Returns
    -------
    BorderLines
        At most N lines, best supported first.
    """
    scale = pixel_scale(image_size[0])
    edges = _edges_of(points)
    for tolerance in FIT_TOLERANCES:
        angles, offsets = _refitted(angles, offsets, edges, tolerance * scale)
    supports = _supports(angles, offsets, edges, image_size)
    return _merged(BorderLines(angles, offsets, supports), scale)


def _edges_of(points: EdgePoints) -> FloatArray:
    """Return x, y, direction as a unit vector, and weight of each point, shape (P, 5)."""
    return np.column_stack(
        (
            points.positions,
            np.cos(points.directions),
            np.sin(points.directions),
            np.minimum(points.contrasts, CONTRAST_CAP),
        )
    )


@compiled_inside
def _weight(  # noqa: PLR0917
    edges: FloatArray, k: int, cos: float, sin: float, offset: float, tolerance: float
) -> float:
    """Return the weight of one of the edges (P, 5) in a line; 0 if it does not belong there."""
    if abs(edges[k, 0] * cos + edges[k, 1] * sin - offset) > tolerance:
        return 0.0
    return edges[k, 4] if edges[k, 2] * cos + edges[k, 3] * sin >= LEAST_COSINE else 0.0


@compiled
def _refitted(
    angles: FloatArray, offsets: FloatArray, edges: FloatArray, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """Return lines by total least squares through the edges (P, 5) about lines (N,), at most N."""
    fitted, shifted = np.empty(len(angles)), np.empty(len(angles))
    moments = np.empty(6)
    count = 0
    for line in range(len(angles)):
        if _add_moments(angles[line], offsets[line], edges, tolerance, moments) >= MINIMUM_POINTS:
            _line_of_moments(moments, angles[line], fitted[count:], shifted[count:])
            count += 1
    return fitted[:count], shifted[:count]


@compiled_loop
def _add_moments(
    angle: float, offset: float, edges: FloatArray, tolerance: float, moments: FloatArray
) -> int:
    """Write the moments of a line's edges: of 1, x, y, xx, xy, yy; return how many edges it has."""
    cos, sin = math.cos(angle), math.sin(angle)
    moments[:] = 0.0
    count = 0
    for k in range(len(edges)):
        weight = _weight(edges, k, cos, sin, offset, tolerance)
        if weight > 0.0:
            x, y = edges[k, 0], edges[k, 1]
            count += 1
            moments[0] += weight
            moments[1] += weight * x
            moments[2] += weight * y
            moments[3] += weight * x * x
            moments[4] += weight * x * y
            moments[5] += weight * y * y
    return count


@compiled_loop
def _line_of_moments(
    moments: FloatArray, angle: float, fitted: FloatArray, shifted: FloatArray
) -> None:
    """Write angle and offset of the line with these moments, whose normal is within 90 degrees."""
    total = moments[0]
    x, y = moments[1] / total, moments[2] / total
    xx, xy, yy = moments[3] / total - x * x, moments[4] / total - x * y, moments[5] / total - y * y
    found = 0.5 * math.atan2(2.0 * xy, xx - yy) + math.pi / 2
    if abs(turn_between(found, angle)) > math.pi / 2:
        found += math.pi
    fitted[0], shifted[0] = found, x * math.cos(found) + y * math.sin(found)


def _supports(
    angles: FloatArray, offsets: FloatArray, edges: FloatArray, image_size: tuple[int, int]
) -> FloatArray:
    """Return the share of each line's visible length that points cover, weighted by contrast.

    A line that only cuts a corner must not win because it is short: it is taken to be at least half
    as long as the smaller side of the picture.
    """
    scale = pixel_scale(image_size[0])
    step = max(COVERED_STEP * scale, 1.0)
    reach = int(np.hypot(*image_size) / 2 / step) + 1
    covered = _covered(angles, offsets, edges, FIT_TOLERANCES[-1] * scale, step, reach)
    lengths = lengths_inside(angles, offsets, image_size)
    lengths = np.maximum(lengths, min(image_size) / 2)
    shares: FloatArray = covered / CONTRAST_CAP * step / lengths
    return np.minimum(shares, 1.0)


@compiled
def _covered(  # noqa: PLR0917
    angles: FloatArray,
    offsets: FloatArray,
    edges: FloatArray,
    tolerance: float,
    step: float,
    reach: int,
) -> FloatArray:
    """Return for lines (N,) the sum over their steps of the highest weight there, (N,)."""
    sums, best = np.empty(len(angles)), np.empty(2 * reach + 1)
    for line in range(len(angles)):
        cos, sin = math.cos(angles[line]), math.sin(angles[line])
        best[:] = 0.0
        for k in range(len(edges)):
            weight = _weight(edges, k, cos, sin, offsets[line], tolerance)
            if weight > 0.0:
                along = math.floor((edges[k, 1] * cos - edges[k, 0] * sin) / step)
                place = min(max(int(along) + reach, 0), 2 * reach)
                best[place] = max(best[place], weight)
        sums[line] = best.sum()
    return sums


def _merged(lines: BorderLines, scale: float) -> BorderLines:
    """Keep the best supported of lines that are the same, best first."""
    lines = lines.taken(np.argsort(-lines.supports, kind="stable"))
    return lines.taken(_first_of_same(lines.angles, lines.offsets, SAME_OFFSET * scale))


@compiled
def _first_of_same(angles: FloatArray, offsets: FloatArray, same_offset: float) -> IndexArray:
    """Return the indices of lines (N,) that differ from all earlier ones that remain."""
    kept, count = np.empty(len(angles), np.int64), 0
    for line in range(len(angles)):
        is_new = True
        for before in kept[:count]:
            turn = abs(turn_between(angles[line], angles[before]))
            if turn < SAME_ANGLE and abs(offsets[line] - offsets[before]) < same_offset:
                is_new = False
        if is_new:
            kept[count] = line
            count += 1
    return kept[:count]
