"""Strips that a map of the frame shows, and where it shows the borders of a given one.

Where to look for a cable whose borders are faint, the best strips of the map say. For each
direction of a fan, the cells are added up along it, and of all intervals across it the one that
overlaps most with what the map takes for cable is a strip without skew. The best of all directions
is then moved, turned, widened and skewed while its overlap grows. What it covers is taken away, and
the next one is looked for.

Where borders of a given strip are steepest need not be where the cable ends. The brightness of a
round cable falls off towards its silhouette, and grown over it is ragged there: the steepest place
of the picture lies inside, and the likelihood puts the border there. The network has learnt where
the silhouette is. It tells that to about a pixel, less finely than borders that are crisp; so what
it says is measured twice, and of the two the smaller counts. Where the strip is half a cable or
less, a bright stripe or a flank in shade, the strip that the map shows clearly replaces it.

A shadow beside a cable has a crisp border, too, on its far side, and where it is about as dark as
the cable the likelihood takes both for one strip. The map shows the cable without it. But of a
cable that sand covers in part it shows the rest, and of a faint one sometimes less than there is;
so what it leaves out is a shadow only where it is darker than the ground beyond it.
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.measure.map.cable_map import (
    AS_THE_STRIP,
    SMALLEST_AREA,
    CableMap,
    MapBorders,
    StripBorders,
    cable_map_of,
    is_worked_out,
    map_overlap,
    share_inside,
    strip_borders,
)
from cable_tracker.cable.model.geometry import border_offset, border_side
from cable_tracker.cable.model.state import ANGLE, DISTANCE, POSE_SIZE, SKEW, STATE_SIZE, WIDTH
from cable_tracker.compilation import compiled, compiled_fast_loop, compiled_inside, compiled_part
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH

DIRECTIONS = 36
"""Number of directions of the fan."""

FIRST_STEPS = np.array([2.0, math.radians(3.0), 2.0, math.radians(3.0)])
"""First steps by which d, alpha, w and beta are changed [cells, rad]."""

HALVINGS, TRIES = 3, 4
"""How often the steps are halved, and how often each is tried at one size."""

MOST_SKEW = math.radians(25.0)
"""Largest skew of a strip that is proposed [rad]; particles about it may have more."""

MAP_BLUR = 0.225
"""How much wider a map shows a crisp strip than it is [cells]."""

FARTHEST, NEAREST = 4.0, 1.0
"""Limits of how far beside a border cells are looked at: half the width within these [cells]."""

MOST_WIDENING = 0.4
"""Limit of the widening, of either sign, as a share of the width."""

LEAST_RIM, MOST_OF_WIDTH = 0.75, 0.45
"""Limits of the width of a shadow: cells at least, and share of the width of the strip at most."""

LEAST_WITH_RIM, LEAST_OVERLAP = 8.0, 1.6
"""Limits of a strip a part of which may be a shadow: its width [cells] and the overlap of the rest
with the map [nats]. Of a thin or faint cable maps show less than there is."""

LEAST_ADDED, LEAST_WHOLE, LARGEST_TURN, LEAST_GAIN = 2.5, 4.0, math.radians(4.0), 0.6
"""Conditions for a strip to be a part of a cable that the map shows, besides `MOST_WIDENING` and
`LEAST_OVERLAP`: how much wider the whole is at least, and its width [cells]; the angle between the
two at most [rad]; and how much more the whole overlaps with the map [nats]. Chosen on two held-out
simulators, AH and AI."""

RIM_STEP, ROUNDS = 0.5, 2
"""Step of the width of a part along a border that is left out [cells], and how often one border
after the other is looked at."""

LEAST_DARKNESS = 0.6
"""How much darker than the ground beyond it a shadow is at least [standard deviations of both].
Shadows of the worlds to tune on are darker by 0.7 to 1.6, sand on a cable by 0.1 to 0.3."""

BESIDE_EDGES = 1.5
"""Pixels nearer to an edge count for neither side of it [px at the reference width]."""

FEWEST_PIXELS = 20
"""Number of pixels on either side that tell how dark a shadow is."""


@compiled
def strips_of_map(cable_map: CableMap, most: int) -> FloatArray:
    """Return at most `most` strips that a map shows, best first, shape (C, 8), rates 0.

    Each is one whose overlap with the map grows no further by a small change. A map without cells,
    or with next to nothing in them, has none.
    """
    strips, rest = np.zeros((most, STATE_SIZE)), cable_map
    for count in range(most):
        if rest.mass < SMALLEST_AREA:
            return strips[:count]
        strip = strips[count]
        _fill_straight_strip(rest, strip)
        refine_strip(rest, strip)
        left = rest.probabilities * (np.float32(1.0) - strip_shares(strip, cable_map))
        rest = cable_map_of(left, cable_map.left, cable_map.top, cable_map.cell)
    return strips


@compiled
def strip_shares(state: FloatArray, cable_map: CableMap) -> Image:
    """Return which share of each cell of a map a strip (8,) covers, float32, of the map's shape."""
    shares: Image = np.empty(cable_map.probabilities.shape, np.float32)
    borders = strip_borders(state, state[WIDTH], cable_map)
    for row in range(shares.shape[0]):
        for column in range(shares.shape[1]):
            shares[row, column] = _share(row, column, borders)
    return shares


@compiled_inside
def _share(row: int, column: int, borders: StripBorders) -> float:
    """Return which share of a cell lies between the borders."""
    left, right = borders
    share: float = share_inside(left[0] + left[1] * row + left[2] * column)
    share *= share_inside(right[0] + right[1] * row + right[2] * column)
    return share


@compiled_part
def _fill_straight_strip(cable_map: CableMap, strip: FloatArray) -> None:
    """Fill in the strip without skew of the largest overlap over all directions."""
    rows, columns = cable_map.probabilities.shape
    bins = math.ceil(math.hypot(rows, columns)) + 1
    masses, areas = np.empty(bins + 1), np.empty(bins + 1)
    best = -1.0
    for direction in range(DIRECTIONS):
        angle = (direction + 0.5) / DIRECTIONS * math.pi - 0.5 * math.pi
        first = _add_up_across(cable_map, angle, masses, areas)
        for begin in range(bins):
            for end in range(begin + 1, bins + 1):
                area, mass = areas[end] - areas[begin], masses[end] - masses[begin]
                overlap = mass / (cable_map.mass + max(area, SMALLEST_AREA))
                if overlap > best:
                    best = overlap
                    strip[DISTANCE] = first + 0.5 * (begin + end) * cable_map.cell
                    strip[ANGLE], strip[WIDTH] = angle, (end - begin) * cable_map.cell


@compiled_fast_loop
def _add_up_across(
    cable_map: CableMap, angle: float, masses: FloatArray, areas: FloatArray
) -> float:
    """Fill in what lies before each step across a direction, shape (B + 1,): mass and cells.

    Steps are one cell wide; where the first one begins is returned [px].
    """
    rows, columns = cable_map.probabilities.shape
    across, down = math.cos(angle), -math.sin(angle)
    lowest = min(0.0, across * (columns - 1)) + min(0.0, down * (rows - 1)) - 0.5
    masses[:], areas[:] = 0.0, 0.0
    for row in range(rows):
        for column in range(columns):
            step = int(across * column + down * row - lowest) + 1
            masses[step] += cable_map.probabilities[row, column]
            areas[step] += 1.0
    for step in range(1, len(masses)):
        masses[step] += masses[step - 1]
        areas[step] += areas[step - 1]
    first: float = cable_map.left * across - cable_map.top * down + lowest * cable_map.cell
    return first


@compiled_part
def refine_strip(cable_map: CableMap, strip: FloatArray) -> None:
    """Change a strip (8,), one number at a time, while its overlap with the map grows."""
    steps = FIRST_STEPS.copy()
    steps[DISTANCE] *= cable_map.cell
    steps[WIDTH] *= cable_map.cell
    best = map_overlap(strip, cable_map)
    for _ in range(HALVINGS + 1):
        for _ in range(TRIES):
            before = best
            for column in range(POSE_SIZE):
                for sign in (-1.0, 1.0):
                    best = _try_step(cable_map, strip, column, sign * steps[column], best)
            if best == before:
                break
        steps *= 0.5


@compiled_part
def _try_step(
    cable_map: CableMap, strip: FloatArray, column: int, step: float, best: float
) -> float:
    """Change one number of a strip if its overlap grows, and return the overlap."""
    kept = strip[column]
    strip[column] += step
    overlap = map_overlap(strip, cable_map)
    if overlap > best and abs(strip[SKEW]) <= MOST_SKEW and strip[WIDTH] >= 0.5 * cable_map.cell:
        return overlap
    strip[column] = kept
    return best


@compiled
def map_borders(
    state: FloatArray, cable_map: CableMap, picture: Image, reduction: float
) -> MapBorders:
    """Return where a map shows the borders of a strip (8,); `AS_THE_STRIP` if it is `NO_MAP`.

    Parameters
    ----------
    state : FloatArray
        The strip [px, rad].
    cable_map : CableMap
        The map.
    picture : Image
        Grey levels, float32 (h, w), in which shadows are dark.
    reduction : float
        Pixels of the picture per pixel of the frame.
    """
    if not is_worked_out(cable_map):
        return AS_THE_STRIP
    nearby = state.copy()
    refine_strip(cable_map, nearby)
    if _is_part_of(state, nearby, cable_map):
        left, right = _parts_beyond(state, nearby, MAP_BLUR * cable_map.cell)
        return MapBorders(0.0, -left, -right)
    widening = _widening(state, nearby, cable_map)
    if state[WIDTH] < LEAST_WITH_RIM * cable_map.cell:
        return MapBorders(widening, 0.0, 0.0)
    # Shadows are rather not cable than half of one: only what is more likely than not counts.
    likely = np.maximum(
        np.float32(2.0) * cable_map.probabilities - np.float32(1.0), np.float32(0.0)
    )
    likely_map = cable_map_of(likely, cable_map.left, cable_map.top, cable_map.cell)
    left_rim, right_rim = _left_out(state, likely_map)
    if map_overlap(_without_rims(state, left_rim, right_rim), cable_map) < LEAST_OVERLAP:
        return MapBorders(widening, 0.0, 0.0)
    if not _is_shadow(state, 0, left_rim, cable_map.cell, picture, reduction):
        left_rim = 0.0
    if not _is_shadow(state, 1, right_rim, cable_map.cell, picture, reduction):
        right_rim = 0.0
    return MapBorders(widening, left_rim, right_rim)


@compiled_inside
def _is_part_of(state: FloatArray, nearby: FloatArray, cable_map: CableMap) -> bool:
    """Tell whether a strip (8,) is only a part of a cable, `nearby` (8,), that a map shows clearly.

    So where a bright stripe of a round cable, or its flank in shade, has clearer borders than the
    whole of it.
    """
    added = nearby[WIDTH] - state[WIDTH]
    if added < max(MOST_WIDENING * state[WIDTH], LEAST_ADDED * cable_map.cell):
        return False
    if nearby[WIDTH] < LEAST_WHOLE * cable_map.cell:
        return False
    if abs(nearby[ANGLE] - state[ANGLE]) > LARGEST_TURN:
        return False
    if abs(nearby[DISTANCE] - state[DISTANCE]) > 0.5 * added + cable_map.cell:
        return False
    overlap = map_overlap(nearby, cable_map)
    gain: float = overlap - map_overlap(state, cable_map)
    return overlap >= LEAST_OVERLAP and gain >= LEAST_GAIN


@compiled_inside
def _parts_beyond(state: FloatArray, nearby: FloatArray, blur: float) -> tuple[float, float]:
    """Return how far beyond the left and the right border of a strip those of `nearby` lie [px].

    At least 0; `blur`: how much wider than a cable a map shows it [px].
    """
    added = nearby[WIDTH] - blur - state[WIDTH]
    shift = nearby[DISTANCE] - state[DISTANCE]
    return max(0.5 * added - shift, 0.0), max(0.5 * added + shift, 0.0)


@compiled_part
def _widening(state: FloatArray, nearby: FloatArray, cable_map: CableMap) -> float:
    """Return how much wider than a strip a map shows it [px]; see `MapBorders`.

    `nearby`: the strip of the map that is refined from it, (8,).
    """
    width, blur = state[WIDTH], MAP_BLUR * cable_map.cell
    by_cells = _widening_by_cells(state, cable_map) - blur
    by_strip: float = nearby[WIDTH] - width - blur
    if by_cells * by_strip <= 0.0:
        return 0.0
    smaller: float = min(abs(by_cells), abs(by_strip), MOST_WIDENING * width)
    return smaller if by_strip > 0.0 else -smaller


@compiled_part
def _left_out(state: FloatArray, cable_map: CableMap) -> tuple[float, float]:
    """Return how wide the parts along the borders are without which a strip overlaps best [px]."""
    left_rim, right_rim = 0.0, 0.0
    for _ in range(ROUNDS):
        left_rim = _best_rim(state, 0, right_rim, cable_map)
        right_rim = _best_rim(state, 1, left_rim, cable_map)
    return left_rim, right_rim


@compiled_part
def _best_rim(state: FloatArray, border: int, other: float, cable_map: CableMap) -> float:
    """Return the width of the part along a border without which a strip overlaps best [px].

    `other` is the width of the part that is left out along the other border [px].
    """
    best, most = 0.0, -math.inf
    step = RIM_STEP * cable_map.cell
    for count in range(int(MOST_OF_WIDTH * state[WIDTH] / step) + 1):
        rim = count * step
        left_rim, right_rim = (rim, other) if border == 0 else (other, rim)
        overlap = map_overlap(_without_rims(state, left_rim, right_rim), cable_map)
        if overlap > most:
            best, most = rim, overlap
    return best


@compiled_part
def _without_rims(state: FloatArray, left_rim: float, right_rim: float) -> FloatArray:
    """Return a strip (8,) without parts along its borders [px]."""
    rest = state.copy()
    rest[DISTANCE] += 0.5 * (left_rim - right_rim)
    rest[WIDTH] -= left_rim + right_rim
    return rest


@compiled_part
def _is_shadow(
    state: FloatArray, border: int, rim: float, cell: float, picture: Image, reduction: float
) -> bool:
    """Tell whether the part along a border of a strip is darker than the ground beyond it.

    `rim` is its width [px]; the ground is looked at as far outwards as that.
    """
    if rim < LEAST_RIM * cell:
        return False
    side = border_side(border)
    angle = state[ANGLE] + side * state[SKEW]
    normal_x, normal_y = math.cos(angle), math.sin(angle)
    offset = border_offset(state[DISTANCE], state[WIDTH], state[SKEW], side)
    height, width = picture.shape
    margin = BESIDE_EDGES * width / (reduction * REFERENCE_WIDTH)
    inside, beyond = np.zeros(3), np.zeros(3)
    for row in range(0, height, 2):
        y = (0.5 * (height - 1) - row) / reduction
        for column in range(0, width, 2):
            x = (column - 0.5 * (width - 1)) / reduction
            inwards = side * (offset - x * normal_x - y * normal_y)
            if abs(inwards) <= margin or abs(inwards) >= rim + margin:
                continue
            level = picture[row, column]
            if inwards < 0.0:
                _add_level(level, beyond)
            elif inwards < rim - margin:
                _add_level(level, inside)
    return _is_darker(inside, beyond)


@compiled_inside
def _add_level(level: float, moments: FloatArray) -> None:
    """Add a grey level to number, sum, and sum of squares of those before, shape (3,)."""
    moments[0] += 1.0
    moments[1] += level
    moments[2] += level * level


@compiled_inside
def _is_darker(one: FloatArray, other: FloatArray) -> bool:
    """Tell whether the levels with some moments (3,) are much darker than others; see `_add_level`.

    Not with fewer than `FEWEST_PIXELS` of either.
    """
    if min(one[0], other[0]) < FEWEST_PIXELS:
        return False
    dark, bright = one[1] / one[0], other[1] / other[0]
    variance = one[2] / one[0] - dark**2
    variance += other[2] / other[0] - bright**2
    is_darker: bool = bright - dark >= LEAST_DARKNESS * math.sqrt(max(0.5 * variance, 1.0))
    return is_darker


@compiled_part
def _widening_by_cells(state: FloatArray, cable_map: CableMap) -> float:
    """Return what cells beside both borders have more than those of the strip would [px]."""
    borders = strip_borders(state, state[WIDTH], cable_map)
    reach = min(max(0.5 * state[WIDTH] / cable_map.cell, NEAREST), FARTHEST)
    outwards = _outwards(borders.left, reach, cable_map)
    outwards += _outwards(borders.right, reach, cable_map)
    return outwards * cable_map.cell


@compiled_fast_loop
def _outwards(border: tuple[float, float, float], reach: float, cable_map: CableMap) -> float:
    """Return how far outwards a map shows a border [cells].

    `border`: how far inwards the first cell lies, and what one row and one column change [cells];
    cells within `reach` of it are looked at.
    """
    excess, count = 0.0, 0
    rows, columns = cable_map.probabilities.shape
    for row in range(rows):
        for column in range(columns):
            inwards = border[0] + border[1] * row + border[2] * column
            if abs(inwards) <= reach:
                excess += cable_map.probabilities[row, column] - share_inside(inwards)
                count += 1
    # The cells within reach, over the width of their band, are the length of the border.
    return excess * 2.0 * reach / max(count, 1)
