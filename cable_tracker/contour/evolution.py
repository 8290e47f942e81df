"""Fast contours: Chan-Vese's energy lowered by switching single points.

Points beside the contour change sides where that costs less. The level set has four values:
exterior, interior, and the two lists between. Table 1 of J. Ha, "Visual tracking and control"
(2008), chapter 3. Where the thesis is silent, it is our choice that: what lies beyond the picture
has no side; neither region is emptied; points that join a list during a scan wait for the next one,
or are checked in the same (`flooding`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.compilation import compiled, compiled_inside, compiled_loop
from cable_tracker.errors import FrameError

Levels: TypeAlias = NDArray[np.int8]
"""Shape (H, W): EXTERIOR, OUTER, INNER or INTERIOR at every pixel."""

EXTERIOR, OUTER, INNER, INTERIOR = 3, 1, -1, -3
"""Outside; outside with a 4-neighbour inside; inside with a 4-neighbour outside; inside."""

FlatLevels: TypeAlias = NDArray[np.int8]
"""Levels with a margin of zeros about the picture, row after row."""

PointList: TypeAlias = NDArray[np.int32]
"""Indices into flat levels."""

INSIDE, OUTSIDE = 0, 1
"""Indices of the two regions in the arrays of `Regions`."""

EDGES, DEPTHS = (INNER, OUTER), (INTERIOR, EXTERIOR)
"""Levels of the regions' points beside the contour, and of the others."""

FEWEST = 2
"""Least number of points in a region: taking one out of one point would divide by zero."""


@compiled
def levels_of_mask(mask: BoolArray) -> Levels:
    """Return the level set whose inside is a mask, shape (H, W).

    What lies beyond the picture is neither inside nor outside: it makes no contour.
    """
    height, width = mask.shape
    levels = np.empty((height, width), np.int8)
    for row in range(height):
        for column in range(width):
            here = mask[row, column]
            differs = (
                (row > 0 and mask[row - 1, column] != here)
                or (row + 1 < height and mask[row + 1, column] != here)
                or (column > 0 and mask[row, column - 1] != here)
                or (column + 1 < width and mask[row, column + 1] != here)
            )
            if here:
                levels[row, column] = INNER if differs else INTERIOR
            else:
                levels[row, column] = OUTER if differs else EXTERIOR
    return levels


@compiled_inside
def _positive_neighbours(levels: FlatLevels, point: int, width: int) -> int:
    """Count the 8-neighbours outside; what lies beyond the picture counts for half."""
    doubled = 0
    for first in (point - width - 1, point - 1, point + width - 1):
        for neighbour in range(first, first + 3):
            if neighbour != point:
                doubled += (levels[neighbour] > 0) + (levels[neighbour] >= 0)
    return doubled // 2


@compiled_inside
def _join_edge(
    levels: FlatLevels, point: int, deep: int, joined: int, points: PointList, count: int
) -> int:
    """Append a point to a list if its level is `deep`; return the length of the list."""
    if levels[point] == deep:
        levels[point] = joined
        points[count] = point
        return count + 1
    return count


@compiled_inside
def _drop_buried(
    levels: FlatLevels, width: int, points: PointList, count: int, own: int, deep: int
) -> int:
    """Remove the points of a list that no longer touch the other side; return its length."""
    kept = 0
    for index in range(count):
        point = points[index]
        if (
            levels[point - 1] * own < 0
            or levels[point + 1] * own < 0
            or levels[point - width] * own < 0
            or levels[point + width] * own < 0
        ):
            points[kept] = point
            kept += 1
        else:
            levels[point] = deep
    return kept


class ContourSettings(NamedTuple):
    """Settings of contour evolution.

    Attributes
    ----------
    regulariser : float
        rho_1 of (17, 18): cost of a neighbour too many on the other side, in units of the data
        term. The thesis gives no value.
    balance : float
        eps_N: the regulariser acts only where the lengths of the two lists differ by more than this
        share; negative: always. The thesis gives no value; its figure 2 implies less than 0.027.
    iterations : int
        Largest number of iterations; hardly any contour needs as many as the default.
    flooding : bool
        Whether points that join a list are checked in the same scan, so that one iteration can
        carry the contour any distance; otherwise by about a pixel.
    """

    regulariser: float = 0.0
    balance: float = 0.02
    iterations: int = 1000
    flooding: bool = True


class Regions(NamedTuple):
    """The inside and the outside of a contour, changed in place.

    Attributes
    ----------
    edges : PointList
        Their points beside the contour, shape (2, H W).
    edge_sizes, sizes : IndexArray
        Number of the points beside the contour, and of all points, shape (2,).
    sums : FloatArray
        Sums of the data over their points, shape (2,).
    """

    edges: PointList
    edge_sizes: IndexArray
    sizes: IndexArray
    sums: FloatArray


@compiled
def switch_points(
    data: NDArray[np.float32],
    levels: Levels,
    settings: ContourSettings,
    by_means: bool,
) -> tuple[int, int, float, float]:
    """Evolve the contour by switching points; `levels` is changed in place.

    Parameters
    ----------
    data : array
        Intensities, or log-likelihood ratios of the inside, shape (H, W).
    levels : Levels
        Level set of the start; afterwards that of the contour, shape (H, W).
    settings : ContourSettings
        Settings of the contour.
    by_means : bool
        Whether Chan-Vese's energy of intensities, (15) and (16), is lowered, or that of the
        log-likelihood ratio.

    Returns
    -------
    tuple
        Iterations done; points inside; sum inside; sum outside.
    """
    height, width = levels.shape
    stride = width + 2
    # A margin of level 0 saves checking whether a neighbour is within the picture.
    padded = np.zeros((height + 2) * stride, np.int8)
    values = np.empty((height + 2) * stride, np.float32)
    regions = Regions(
        np.empty((2, height * width), np.int32),
        np.zeros(2, np.int64),
        np.zeros(2, np.int64),
        np.zeros(2),
    )
    _initialise(data, levels, padded, values, regions)
    iterations, has_changed = 0, True
    while iterations < settings.iterations and has_changed:
        iterations += 1
        has_changed = False
        for region in (INSIDE, OUTSIDE):
            has_changed |= _scan(region, padded, values, stride, regions, settings, by_means)
            other = 1 - region
            regions.edge_sizes[other] = _drop_buried(
                padded,
                stride,
                regions.edges[other],
                regions.edge_sizes[other],
                EDGES[other],
                DEPTHS[other],
            )
    for row in range(height):
        first = (row + 1) * stride + 1
        for column in range(width):
            levels[row, column] = padded[first + column]
    return iterations, regions.sizes[INSIDE], regions.sums[INSIDE], regions.sums[OUTSIDE]


@compiled_loop
def _initialise(
    data: NDArray[np.float32],
    levels: Levels,
    padded: FlatLevels,
    values: NDArray[np.float32],
    regions: Regions,
) -> None:
    """Fill in padded levels, padded values and regions from a picture and its levels."""
    height, width = levels.shape
    inner, outer, inside, inside_sum, outside_sum = 0, 0, 0, 0.0, 0.0
    for row in range(height):
        first = (row + 1) * (width + 2) + 1
        for column in range(width):
            padded[first + column] = levels[row, column]
            values[first + column] = data[row, column]
        for column in range(width):
            level, value = levels[row, column], data[row, column]
            if level < 0:
                inside += 1
                inside_sum += value
                if level == EDGES[INSIDE]:
                    regions.edges[INSIDE, inner] = first + column
                    inner += 1
            else:
                outside_sum += value
                if level == EDGES[OUTSIDE]:
                    regions.edges[OUTSIDE, outer] = first + column
                    outer += 1
    regions.edge_sizes[INSIDE], regions.edge_sizes[OUTSIDE] = inner, outer
    regions.sizes[INSIDE], regions.sizes[OUTSIDE] = inside, height * width - inside
    regions.sums[INSIDE], regions.sums[OUTSIDE] = inside_sum, outside_sum


@compiled_loop
def _scan(
    region: int,
    padded: FlatLevels,
    values: NDArray[np.float32],
    stride: int,
    regions: Regions,
    settings: ContourSettings,
    by_means: bool,
) -> bool:
    """Switch the edge points of one region where that lowers the energy; return whether any was."""
    other = 1 - region
    sign = 1.0 if region == INSIDE else -1.0
    edge, foreign_edge, depth = EDGES[region], EDGES[other], DEPTHS[region]
    own, foreign = regions.edges[region], regions.edges[other]
    size, foreign_size = regions.sizes[region], regions.sizes[other]
    total, foreign_total = regions.sums[region], regions.sums[other]
    count, foreign_count = regions.edge_sizes[region], regions.edge_sizes[other]
    smooth = 0.0
    if count > 0 and abs(1.0 - foreign_count / count) > settings.balance:
        smooth = sign * settings.regulariser
    kept, index, end, has_changed = 0, 0, count, False
    while index < end:
        point = own[index]
        index += 1
        value = values[point]
        change = sign * value
        if by_means:
            from_own, from_other = value - total / size, value - foreign_total / foreign_size
            change = from_other * from_other * (foreign_size / (foreign_size + 1.0))
            change -= from_own * from_own * (size / (size - 1.0))
        if smooth != 0.0:
            change += smooth * (4 - _positive_neighbours(padded, point, stride))
        if change >= 0.0 or size <= FEWEST:
            own[kept] = point
            kept += 1
            continue
        padded[point] = foreign_edge
        foreign[foreign_count] = point
        foreign_count += 1
        has_changed = True
        size, foreign_size = size - 1, foreign_size + 1
        total, foreign_total = total - value, foreign_total + value
        for neighbour in (point - stride, point - 1, point + 1, point + stride):
            count = _join_edge(padded, neighbour, depth, edge, own, count)
        if settings.flooding:
            end = count
    while index < count:
        own[kept] = own[index]
        kept += 1
        index += 1
    regions.edge_sizes[region], regions.edge_sizes[other] = kept, foreign_count
    regions.sizes[region], regions.sizes[other] = size, foreign_size
    regions.sums[region], regions.sums[other] = total, foreign_total
    return has_changed


@dataclass(frozen=True, slots=True, eq=False)
class Contour:
    """Result of an evolution.

    Attributes
    ----------
    levels : Levels
        Level set, shape of the picture.
    iterations : int
        Number of iterations that were done.
    inside_mean, outside_mean : float
        Mean of the data on either side.
    """

    levels: Levels
    iterations: int
    inside_mean: float
    outside_mean: float

    @property
    def mask(self) -> BoolArray:
        """The inside, shape of the picture."""
        inside: BoolArray = self.levels < 0
        return inside

    @property
    def contrast(self) -> float:
        """Difference of the two means, positive."""
        return abs(self.inside_mean - self.outside_mean)


def evolve(
    data: NDArray[np.float32], start: BoolArray, settings: ContourSettings, *, by_means: bool
) -> Contour:
    """Evolve a contour: Table 1 of the thesis.

    Parameters
    ----------
    data : array
        Intensities in [0, 1], or log p(pixel | target) / p(pixel | background), plus the log-odds
        of a shape prior where there is one (`shapes.log_odds`); shape (H, W), float32.
    start : BoolArray
        Inside at the start, of the same shape.
    settings : ContourSettings
        Settings of the contour.
    by_means : bool
        Whether `data` are intensities, separated by their means, or log-likelihood ratios,
        separated by their sign.

    Raises
    ------
    FrameError
        The shapes differ, or one of the regions has fewer than two points.
    """
    if data.ndim != 2 or data.shape != start.shape:
        raise FrameError(f"a contour of shape {start.shape} cannot evolve on data {data.shape}")
    levels = levels_of_mask(start)
    inside = int(np.count_nonzero(levels < 0))
    if min(inside, levels.size - inside) < FEWEST:
        raise FrameError(
            f"a contour needs {FEWEST} points on either side,"
            f" not {inside} and {levels.size - inside}"
        )
    pixels = np.ascontiguousarray(data, dtype=np.float32)
    iterations, inside, inside_sum, outside_sum = switch_points(pixels, levels, settings, by_means)
    return Contour(
        levels=levels,
        iterations=iterations,
        inside_mean=inside_sum / inside,
        outside_mean=outside_sum / (levels.size - inside),
    )
