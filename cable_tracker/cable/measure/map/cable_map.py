"""Map of the probability that cells of a picture are cable, and how well a strip matches it.

The network that makes it takes several times as long as the rest of a frame in which the cable is
clear. So beside a known cable it looks only now and then. The last map is kept, and what it said of
the strip, of its borders and of what lies beside it stays true for a moment, but for how the cable
has moved since. Borders alone prefer a bright stripe along a pipe, or its lit half, to the whole of
it: some time after the last map the filter would go over to the stripe.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.geometry import border_offset, pose_in_chart
from cable_tracker.cable.model.state import ANGLE, DISTANCE, POSE_SIZE, SKEW, WIDTH
from cable_tracker.compilation import compiled, compiled_fast_loop, compiled_inside

SMALLEST_SHARE = 0.01
"""Added to a share and to the rest before their ratio is taken: no cell is sure."""

RESOLVED_WIDTH, SHARPEST_WIDTH = 3.0, 1.5
"""Width of the narrowest strip that a map always tells from a wider one [cells]: matched by its own
width, a thin strip would lose to one as wide as the map's blur. And of the narrowest band that a
map shows where it is not blurred."""

SMALLEST_AREA = 0.5
"""Lower bound of the area of a strip [cells]."""

CLEAR_OVERLAP = 1.1
"""Overlap of the best strip of a map from which on what others lack to it counts in a search: three
quarters of what both cover are common to both [nats]. Chosen on a held-out simulator, AH."""

SLACK = 1.0
"""Difference of overlaps with a kept map, or in a search, that counts as none [nats]. How exactly
the cable has moved since the kept map is not known, nor how exactly a map shows a cable."""

LONGEST_KEPT = 1.0
"""Age from which on a map says nothing any more [s]."""

BORDERS_TIME = 0.5
"""Time over which the borders by maps are smoothed [s]."""


class CableMap(NamedTuple):
    """Probabilities that cells of the picture are part of a cable.

    Attributes
    ----------
    probabilities : Image
        float32, shape (rows, columns), from the top left; (0, 0) if they were not worked out.
    sums_along_rows, sums_along_columns : FloatArray
        Sums of the probabilities of the cells before each edge between two, shapes (rows,
        columns + 1) and (columns, rows + 1): the difference of two is the sum over those between.
    mass : float
        Sum of all probabilities.
    left, top : float
        Coordinates of the centre of the first cell in the image frame, y up [px].
    cell : float
        Side of a cell [px].
    """

    probabilities: Image
    sums_along_rows: FloatArray
    sums_along_columns: FloatArray
    mass: float
    left: float
    top: float
    cell: float


@compiled
def cable_map_of(probabilities: Image, left: float, top: float, cell: float) -> CableMap:
    """Return the map of some probabilities; see `CableMap`."""
    rows, columns = probabilities.shape
    along_rows, along_columns = np.zeros((rows, columns + 1)), np.zeros((columns, rows + 1))
    for row in range(rows):
        for column in range(columns):
            found = probabilities[row, column]
            along_rows[row, column + 1] = along_rows[row, column] + found
            along_columns[column, row + 1] = along_columns[column, row] + found
    return CableMap(
        probabilities=probabilities,
        sums_along_rows=along_rows,
        sums_along_columns=along_columns,
        mass=along_rows[:, -1].sum(),
        left=left,
        top=top,
        cell=cell,
    )


NO_MAP = CableMap(
    probabilities=np.empty((0, 0), np.float32),
    sums_along_rows=np.empty((0, 1)),
    sums_along_columns=np.empty((0, 1)),
    mass=0.0,
    left=0.0,
    top=0.0,
    cell=1.0,
)
"""The map of a frame of which none was worked out."""


@compiled_inside
def is_worked_out(cable_map: CableMap) -> bool:
    """Tell whether a map is one, and not `NO_MAP`."""
    return len(cable_map.probabilities) > 0


class MapMatch(NamedTuple):
    """How well a strip matches a map.

    Attributes
    ----------
    overlap_share : float
        Overlap of the strip with what the map takes for cable, 0 to 1: twice what both have in
        common over the sum of both.
    inside_share : float
        Mean probability inside the strip.
    """

    overlap_share: float
    inside_share: float


@compiled_fast_loop
def map_match(state: FloatArray, cable_map: CableMap) -> MapMatch:
    """Return how well a strip (8,) matches a map, not at all if that is `NO_MAP`.

    A strip narrower than `RESOLVED_WIDTH` matches as one of that width or of `SHARPEST_WIDTH`,
    whichever overlaps more: how wide such a cable is, its borders tell, and not the map.
    """
    resolved = RESOLVED_WIDTH * cable_map.cell
    area, mass = _covered(state, max(state[WIDTH], resolved), cable_map)
    if state[WIDTH] < resolved:
        sharp_width = SHARPEST_WIDTH * cable_map.cell
        sharp_area, sharp_mass = _covered(state, sharp_width, cable_map)
        if sharp_mass * (cable_map.mass + area) > mass * (cable_map.mass + sharp_area):
            area, mass = sharp_area, sharp_mass
    area = max(area, SMALLEST_AREA)
    return MapMatch(2.0 * mass / (cable_map.mass + area), min(mass / area, 1.0))


@compiled
def map_overlap(state: FloatArray, cable_map: CableMap) -> float:
    """Return the log-odds of the overlap of a strip (4 or more,) with a map [nats]."""
    return bounded_log_odds(map_match(state, cable_map).overlap_share)


@compiled_fast_loop
def _covered(state: FloatArray, width: float, cable_map: CableMap) -> tuple[float, float]:
    """Return the number of cells that a strip covers, and the sum of their probabilities.

    The width [px] takes the place of its own.
    """
    borders = strip_borders(state, width, cable_map)
    if abs(math.cos(state[ANGLE])) >= abs(math.sin(state[ANGLE])):
        return _covered_along(cable_map.sums_along_rows, borders.left, borders.right)
    left, right = borders
    return _covered_along(
        cable_map.sums_along_columns,
        (left[0], left[2], left[1]),
        (right[0], right[2], right[1]),
    )


@compiled_inside
def _covered_along(
    sums: FloatArray, left: tuple[float, float, float], right: tuple[float, float, float]
) -> tuple[float, float]:
    """Return the cells between two borders on all lines, and the sum of their probabilities.

    The borders, see `StripBorders`: how far inwards the first cell lies, and what one line, and one
    cell along a line, change.
    """
    lines, last = sums.shape[0], sums.shape[1] - 1.0
    area, mass = 0.0, 0.0
    for line in range(lines):
        # In edges between cells: the first one lies half a cell before the centre of the first.
        first = 0.5 - (left[0] + left[1] * line) / left[2]
        second = 0.5 - (right[0] + right[1] * line) / right[2]
        begin, end = (first, second) if left[2] > 0.0 else (second, first)
        begin, end = min(max(begin, 0.0), last), min(max(end, 0.0), last)
        if end > begin:
            area += end - begin
            mass += _sum_before(sums[line], end) - _sum_before(sums[line], begin)
    return area, mass


@compiled_inside
def _sum_before(sums: FloatArray, edge: float) -> float:
    """Return the sum before a place between edges, 0 to the number of cells."""
    before = min(int(edge), len(sums) - 2)
    sum_before: float = sums[before] + (edge - before) * (sums[before + 1] - sums[before])
    return sum_before


class StripBorders(NamedTuple):
    """How far inwards of each border the centre of a cell lies [cells]: linear in row and column.

    Of each: that of the first cell, and what one row and one column change.
    """

    left: tuple[float, float, float]
    right: tuple[float, float, float]


@compiled_fast_loop
def strip_borders(state: FloatArray, width: float, cable_map: CableMap) -> StripBorders:
    """Return the borders of a strip of some width [px] as they cross the cells of a map."""
    angle, skew = state[ANGLE], state[SKEW]
    left_x, left_y = math.cos(angle - skew), math.sin(angle - skew)
    right_x, right_y = math.cos(angle + skew), math.sin(angle + skew)
    left_offset = border_offset(state[DISTANCE], width, skew, -1.0)
    right_offset = border_offset(state[DISTANCE], width, skew, 1.0)
    return StripBorders(
        (
            (cable_map.left * left_x + cable_map.top * left_y - left_offset) / cable_map.cell,
            -left_y,
            left_x,
        ),
        (
            (right_offset - cable_map.left * right_x - cable_map.top * right_y) / cable_map.cell,
            right_y,
            -right_x,
        ),
    )


@compiled_inside
def share_inside(inwards: float) -> float:
    """Return which share of a cell lies inwards of a border, as of one across its middle.

    `inwards`: how far its centre lies inwards [cells].
    """
    return min(max(inwards + 0.5, 0.0), 1.0)


@compiled_inside
def bounded_log_odds(share: float) -> float:
    """Return the log-odds of a share, 0 to 1, bounded [nats]."""
    return math.log((share + SMALLEST_SHARE) / (1.0 + SMALLEST_SHARE - share))


class MapWeights(NamedTuple):
    """How much a map counts in the likelihood [nats per nat].

    Attributes
    ----------
    overlap : float
        Weight of the overlap of a strip with the map.
    lacking : float
        Weight of the difference, if positive, of the expected strip's overlap and that one.
    """

    overlap: float
    lacking: float


class ExpectedOverlap(NamedTuple):
    """Bounds of the log-odds of overlaps with a map [nats].

    Attributes
    ----------
    enough : float
        Overlap above which more does not count; infinite in the map of the frame itself.
    expected : float
        Overlap of the strip that is expected; what others lack to it counts besides, see
        `MapWeights`. -inf where none is expected.
    """

    enough: float
    expected: float


NOTHING_EXPECTED = ExpectedOverlap(math.inf, -math.inf)
"""Without a map, and in a search in whose map no strip is clear."""


def overlap_of_expected(
    cable_map: CableMap, state: FloatArray, *, is_kept: bool
) -> ExpectedOverlap:
    """Return the bounds of overlaps beside a known cable, whose expected state is (8,).

    `is_kept`: the map is of a frame before.
    """
    if not is_worked_out(cable_map):
        return NOTHING_EXPECTED
    overlap = map_overlap(state, cable_map)
    if is_kept:
        return ExpectedOverlap(enough=overlap - SLACK, expected=overlap - SLACK)
    return ExpectedOverlap(enough=math.inf, expected=overlap)


def overlap_of_best(cable_map: CableMap, strips: FloatArray) -> ExpectedOverlap:
    """Return the bounds of overlaps in a search: by the best strip of the map, if it is clear.

    `strips`: those that the map shows, best first, shape (C, 8).
    """
    best = map_overlap(strips[0], cable_map) if len(strips) else -math.inf
    if best < CLEAR_OVERLAP:
        return NOTHING_EXPECTED
    return ExpectedOverlap(enough=math.inf, expected=best - SLACK)


@compiled_inside
def map_log_ratio(
    state: FloatArray, cable_map: CableMap, against: ExpectedOverlap, weights: MapWeights
) -> float:
    """Return what a map adds to the log-likelihood ratio of a strip (8,), 0 for `NO_MAP` [nats].

    In a kept map, moved along with the cable, strips that overlap nearly as well as the expected
    one get the same, and borders decide.
    """
    if not is_worked_out(cable_map):
        return 0.0
    overlap = bounded_log_odds(map_match(state, cable_map).overlap_share)
    lacking = max(against.expected - overlap, 0.0)
    log_ratio: float = weights.overlap * min(overlap, against.enough) - weights.lacking * lacking
    return log_ratio


class MapBorders(NamedTuple):
    """Where a map shows the borders of a strip.

    Attributes
    ----------
    widening : float
        How much wider than the strip the map shows it [px], below 0 if it is narrower; the smaller
        of what the cells beside its borders and the strip nearby that overlaps best with the map
        say, 0 if they disagree which way.
    left_rim, right_rim : float
        Widths of the parts along its borders that are shadows beside the cable [px]; 0: none. Below
        0 where the strip is only a part of the cable: how far that goes on beyond the border.
    """

    widening: float
    left_rim: float
    right_rim: float


AS_THE_STRIP = MapBorders(0.0, 0.0, 0.0)
"""Where nothing else is said."""


@dataclass(frozen=True, slots=True, eq=False)
class KeptMap:
    """A map of a frame before.

    Attributes
    ----------
    cable_map : CableMap
        The map.
    pose : FloatArray
        d, alpha, w, beta of the cable in that frame, shape (4,) [px, rad].
    borders : MapBorders
        Where it and the maps before it show the borders of the cable, smoothed [px].
    seconds : float
        Time since that frame [s].
    """

    cable_map: CableMap
    pose: FloatArray
    borders: MapBorders
    seconds: float = 0.0

    def smoothed(self, borders: MapBorders) -> MapBorders:
        """Return where this map and a new one, which shows `borders`, show those of the cable."""
        kept = math.exp(-self.seconds / BORDERS_TIME)
        both = zip(self.borders, borders, strict=True)
        return MapBorders(*(kept * old + (1.0 - kept) * new for old, new in both))

    def moved_to(self, pose: FloatArray) -> CableMap:
        """Return the map as it lies when the centreline of the cable has come to that of a pose.

        It turns about the image centre and moves across the centreline; `pose` (4 or more,) is one
        in any chart. Cells that come from beyond the picture are as the outermost ones. One that is
        `LONGEST_KEPT` old is `NO_MAP`.
        """
        if self.seconds >= LONGEST_KEPT:
            return NO_MAP
        probabilities = cv2.warpAffine(
            self.cable_map.probabilities,
            _cells_before(self.cable_map, self.pose, pose),
            self.cable_map.probabilities.shape[::-1],
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        cells = np.asarray(probabilities, np.float32)
        return cable_map_of(cells, self.cable_map.left, self.cable_map.top, self.cable_map.cell)


NO_KEPT_MAP = KeptMap(NO_MAP, np.zeros(POSE_SIZE), AS_THE_STRIP, math.inf)
"""Before any map: too old to say anything."""


@compiled
def _cells_before(cable_map: CableMap, before: FloatArray, now: FloatArray) -> FloatArray:
    """Return the affine map, shape (2, 3), from (column, row) of a moved map to those before.

    Parameters
    ----------
    cable_map : CableMap
        The map before.
    before, now : FloatArray
        Poses of the cable, shape (4,) or more, in any chart [px, rad]: it has turned about the
        image centre, and then moved along the normal of its centreline.
    """
    left, top, cell, angle = cable_map.left, cable_map.top, cable_map.cell, now[ANGLE]
    in_chart = np.empty(POSE_SIZE)
    pose_in_chart(before, angle, in_chart)
    turned, moved = angle - in_chart[ANGLE], now[DISTANCE] - in_chart[DISTANCE]
    cosine, sine = math.cos(turned), math.sin(turned)
    # From the image frame, y up: p = R(-turned) (p' - moved n').
    first_x = left - moved * math.cos(angle)
    first_y = top - moved * math.sin(angle)
    # Rows run downwards: (x', y') = first + cell (column, -row).
    return np.array(
        [
            [cosine, -sine, (cosine * first_x + sine * first_y - left) / cell],
            [sine, cosine, (top + sine * first_x - cosine * first_y) / cell],
        ]
    )
