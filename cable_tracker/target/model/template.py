"""The template of a target's shape: signed distances, and points to measure at."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.compilation import compiled, compiled_inside
from cable_tracker.contour.shapes import signed_distances
from cable_tracker.errors import FrameError
from cable_tracker.tracking.image_frame import to_image

SIDE, MOST_SIDE = 97, 481
"""Rows and columns of the map of distances, at least and at most; odd, the origin is in the middle.
The least holds what reaches 1.5 units from its centroid with a ring around it, the most 9.5."""

UNIT = 24.0
"""Pixels of the distance map per template unit (1 unit = square root of the target's area)."""

THIN, LONG = 0.135, 10.0
"""A bar is nowhere as deep as THIN, in units: one of 1 by 14 is. Its pixels scatter along it more
than LONG times as far as across, not so those of a thin ring."""

RING = (0.12, 0.5)
"""The points around the target are this far from its outline, in units."""

LEAST_AREA = 12
"""Pixels that a shape needs."""

LEAST_BOX = 3.3
"""A marked box of this side has as many, wherever it lies between the pixels [px]."""

GOLDEN = (0.7548776662466927, 0.5698402909980532)
"""Steps of a sequence that fills the square evenly (M. Roberts' R2)."""


@dataclass(frozen=True, slots=True, eq=False)
class Template:
    """A shape about its centroid, of area 1.

    Attributes
    ----------
    distances : array
        Signed distances from the outline, negative inside, in units; float32, shape (S, S) with S
        from SIDE to MOST_SIDE, rows downwards.
    size : float
        Length of a unit at scale 1 [px of the working image].
    inside, around : FloatArray
        Points inside and in a ring outside, x right, y up, in units; shape (K, 2).
    """

    distances: NDArray[np.float32]
    size: float
    inside: FloatArray
    around: FloatArray

    @property
    def reach(self) -> float:
        """Distance from the centroid that the shape does not exceed, in units."""
        rows, columns = np.nonzero(self.distances < 0.0)
        middle = (len(self.distances) - 1) / 2
        return float(np.hypot(rows - middle, columns - middle).max() + 1.0) / UNIT

    @property
    def is_bar(self) -> bool:
        """Whether the shape is a thin bar, of which the visible share of the length is unknown."""
        if float(self.distances.min()) <= -THIN:
            return False
        across, along = np.linalg.eigvalsh(np.cov(np.nonzero(self.distances < 0.0)))
        return bool(along > LONG**2 * across)

    def extent(self, angle: float) -> tuple[float, float]:
        """Return the half width and half height of the turned shape, in units."""
        rows, columns = np.nonzero(self.distances < 0.0)
        side = len(self.distances)
        x, y = (each / UNIT for each in to_image(columns, rows, (side, side)))
        across = math.cos(angle) * x - math.sin(angle) * y
        up = math.sin(angle) * x + math.cos(angle) * y
        half = 0.5 / UNIT
        return float(np.abs(across).max() + half), float(np.abs(up).max() + half)


def make_template(distances: NDArray[np.float32], size: float, points: int) -> Template:
    """Return the template with its points.

    Parameters
    ----------
    distances, size
        Distance map and size, see `Template`.
    points : int
        Number of points inside, and of those around; fewer for a shape of hardly any area.
    """
    inside, around = spread_points(distances, points)
    return Template(distances, size, inside, around)


def check_area(mask: BoolArray, zoom: float) -> None:
    """Check that a mask has enough pixels for a shape; `zoom` frame pixels are one of its pixels.

    Raises
    ------
    FrameError
        It is too small.
    """
    if int(mask.sum()) < LEAST_AREA:
        side = math.ceil(LEAST_BOX * zoom)
        raise FrameError(
            "the marked target is too small to have a shape; mark a box of"
            f" {side}x{side} px at least"
        )


def template_of_mask(mask: BoolArray, points: int, zoom: float) -> Template:
    """Return the template of a mask, shape (H, W), upright as it is.

    Raises
    ------
    FrameError
        The mask is too small for a shape, see `check_area`.
    """
    check_area(mask, zoom)
    centre = centroid(mask)
    size = math.sqrt(int(mask.sum()))
    side = _side_for(mask, centre, size)
    return make_template(distances_about(mask, centre, size, 0.0, side), size, points)


def _side_for(mask: BoolArray, centre: tuple[float, float], size: float) -> int:
    """Return the side of a map that holds a mask (H, W) and its ring [rows, columns].

    Parameters
    ----------
    centre : (float, float)
        Origin of the map from the image centre, y up [px].
    size : float
        Length of a unit [px].
    """
    height, width = mask.shape
    rows, columns = np.nonzero(mask)
    x, y = to_image(columns, rows, (width, height))
    farthest = float(max(np.abs(x - centre[0]).max(), np.abs(y - centre[1]).max())) + 0.5
    reach = farthest / size + RING[1]
    return min(max(2 * math.ceil(reach * UNIT) + 1, SIDE), MOST_SIDE)


def centroid(mask: BoolArray) -> tuple[float, float]:
    """Return x and y of a mask's centre, from the image centre, y up [px]."""
    height, width = mask.shape
    rows, columns = np.nonzero(mask)
    return to_image(float(columns.mean()), float(rows.mean()), (width, height))


def distances_about(
    mask: BoolArray, centre: tuple[float, float], size: float, angle: float, side: int
) -> NDArray[np.float32]:
    """Return the distances of a mask in the frame of a template, shape (side, side), in units.

    Parameters
    ----------
    mask : BoolArray
        Pixels of the target, shape (H, W).
    centre : (float, float)
        Origin of the template from the image centre, y up [px].
    size : float
        Length of a unit [px].
    angle : float
        Angle of the template in the image [rad].
    side : int
        Rows and columns of the map; odd.
    """
    return _into_template(signed_distances(mask), centre[0], centre[1], size, angle, side)


@compiled_inside
def interpolated(distances: NDArray[np.float32], column: float, row: float) -> tuple[float, float]:
    """Return the distance at a place of a map (H, W), and how far beyond the map it is [px].

    Bilinear; beyond the map it is that of the nearest place within, and grows as it does there.
    """
    height, width = distances.shape
    inner_column = min(max(column, 0.0), width - 1.0)
    inner_row = min(max(row, 0.0), height - 1.0)
    beyond = math.hypot(column - inner_column, row - inner_row)
    left, top = min(int(inner_column), width - 2), min(int(inner_row), height - 2)
    a, b = inner_column - left, inner_row - top
    value = (1.0 - b) * ((1.0 - a) * distances[top, left] + a * distances[top, left + 1])
    value += b * ((1.0 - a) * distances[top + 1, left] + a * distances[top + 1, left + 1])
    return value, beyond


@compiled
def _into_template(  # noqa: PLR0917
    distances: NDArray[np.float32], x: float, y: float, size: float, angle: float, side: int
) -> NDArray[np.float32]:
    height, width = distances.shape
    cosine, sine = math.cos(angle), math.sin(angle)
    middle = (side - 1) / 2
    result = np.empty((side, side), np.float32)
    for i in range(side):
        for j in range(side):
            across, up = (j - middle) / UNIT * size, (middle - i) / UNIT * size
            column = (width - 1) / 2 + x + cosine * across - sine * up
            row = (height - 1) / 2 - y - sine * across - cosine * up
            value, beyond = interpolated(distances, column, row)
            result[i, j] = (value + beyond) / size
    return result


@compiled
def spread_points(distances: NDArray[np.float32], count: int) -> tuple[FloatArray, FloatArray]:
    """Return points spread evenly inside a shape, and in the `RING` around it, in units.

    Parameters
    ----------
    distances : array
        Distance map of the shape, shape (S, S), in units.
    count : int
        Number of points of either kind; fewer where hardly any place fits.
    """
    inside, around = np.empty((count, 2)), np.empty((count, 2))
    found_inside = found_around = 0
    first = second = 0.5
    nearest, farthest = RING
    side = len(distances)
    middle = (side - 1) / 2
    for _ in range(400 * count * side * side // (SIDE * SIDE)):
        if found_inside == count and found_around == count:
            break
        first, second = (first + GOLDEN[0]) % 1.0, (second + GOLDEN[1]) % 1.0
        column, row = first * (side - 1), second * (side - 1)
        distance = distances[int(row + 0.5), int(column + 0.5)]
        x, y = (column - middle) / UNIT, (middle - row) / UNIT
        if distance < 0.0 and found_inside < count:
            inside[found_inside] = (x, y)
            found_inside += 1
        elif nearest <= distance <= farthest and found_around < count:
            around[found_around] = (x, y)
            found_around += 1
    return inside[:found_inside], around[:found_around]
