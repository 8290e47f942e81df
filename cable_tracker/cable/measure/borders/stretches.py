"""The ratios of the points of a cable's borders, summed by stretches of the cable.

A cable may be bright in some places and dark in others: painted bands, growth, another bottom. The
picture is divided into stretches along the cable. One whose borders both say that it is of the
other polarity is counted as such, at a cost: without the cost, anything would be a cable that
changes often enough. Most of a bright cable is bright, or a shadow would be one, too.

Shorter bands are those of a *striped* cable: each point of its borders is bright or dark, whatever
its neighbours are. That costs as much as one reversed stretch, and a point whose polarity is clear
says ln 2 less. Strands are not found so: their edges run askew to the border.

A cost for each band, whatever its length, was tried in place of one for each stretch: of the banded
cables of the worlds to tune on fewer were found, and no other world was the better for it.

One end of a cable may be covered: it goes into the sand, or ends. Beyond the place where it goes
under, the points of its borders say that there is none. From one end on stretches are left out, at
a cost, if together they speak against the cable by more than that: without the cost, any short edge
would be a cable. A third of what is in view has to be left. Both ends were tried, too, as of a
cable that only shows in the middle of the picture: on the worlds to tune on less was found.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import Float32Array, FloatArray, IndexArray
from cable_tracker.cable.measure.borders.border_points import (
    BLOCK,
    BorderLine,
    Crossings,
    find_crossings,
    measure_contrasts,
    measure_responses,
    padded_count,
)
from cable_tracker.cable.measure.borders.response_table import CLASSES, point_cell
from cable_tracker.cable.measure.scanned_gradients import ScanInputs, ScanLines
from cable_tracker.cable.model.state import ANGLE
from cable_tracker.compilation import compiled_fast_loop, compiled_inside, compiled_loop

HALF = np.float32(0.5)
LOG_2 = np.float32(math.log(2.0))

STRETCHES = 16
"""Number of stretches of a cable along the diagonal of the picture."""

LEAST_SHOWN, SHOWN_PART = 3, 3
"""Stretches that are left at least; and one in so many of those in view."""

MOST_UNSEEN = 0.4
"""Share of the stretches in view without which a cable is looked at, at most. If more is covered,
it may be a bar that ends: of 33 pictures of real ground with one on it, swayed over, 0.4 % of the
frames are claimed, with half in place of this share 14 %."""


class StretchScale(NamedTuple):
    """Which stretch a border is in where it crosses a scan line: start + step v, rounded down.

    Attributes
    ----------
    start, step : float
        v is that of `ScanLines.places` [working px].
    """

    start: float
    step: float


class StretchAxis(NamedTuple):
    """The direction in which stretches of a cable follow each other, and how many lie on a pixel.

    Attributes
    ----------
    x, y : float
        Unit vector along the centreline.
    per_pixel : float
        Stretches per working px.
    """

    x: float
    y: float
    per_pixel: float


@compiled_inside
def stretch_axis(state: FloatArray, scan: ScanInputs) -> StretchAxis:
    """Return the axis of a cable, shape (8,), that both of its borders share."""
    width, height = scan.rows.smooth.shape[1], scan.columns.smooth.shape[1]
    per_pixel = STRETCHES / math.hypot(width, height)
    return StretchAxis(-math.sin(state[ANGLE]), math.cos(state[ANGLE]), per_pixel)


@compiled_inside
def stretch_scale(axis: StretchAxis, border: BorderLine) -> StretchScale:
    """Return which stretches a border of a cable is in."""
    along_line, across = (axis.x, axis.y) if border.is_steep else (axis.y, axis.x)
    step = (border.step * along_line + across) * axis.per_pixel
    return StretchScale(border.start * along_line * axis.per_pixel + 0.5 * STRETCHES, step)


@compiled_inside
def stretch_at(scale: StretchScale, place: float) -> int:
    """Return the stretch that a border is in where it crosses the scan line at v [working px]."""
    return int(min(max(scale.start + scale.step * place, 0.0), STRETCHES - 1.0))


@compiled_inside
def fill_by_stretch(
    values: FloatArray, scale: StretchScale, places: FloatArray, result: FloatArray
) -> None:
    """Fill in, for each scan line, the value of the stretch in which a border crosses it.

    `values` has shape (`STRETCHES`,), `places` (L,) are v of the lines, `result` is as long at
    least.
    """
    for index in range(len(places)):
        result[index] = values[stretch_at(scale, places[index])]


@compiled_inside
def sum_border(
    lines: ScanLines,
    border: BorderLine,
    scale: StretchScale,
    ratios: Float32Array,
    crossings: Crossings,
    stretches: Float32Array,
    striped: Float32Array,
) -> float:
    """Fill in the sums of a border, and return its length in view.

    `stretches` (8, `STRETCHES`) are those of the ratios, `striped` (4,) those of a striped cable,
    see `sum_stretches`; `ratios` are those of `ResponseTable.ratios`.
    """
    stretches[:] = np.float32(0.0)
    striped[:] = np.float32(0.0)
    count = 0
    for start in range(0, len(lines.places), BLOCK):
        first, found = find_crossings(lines, start, border, crossings)
        measure_responses(lines, first, found, border, crossings)
        measure_contrasts(lines, first, found, border, crossings)
        _add_ratios(
            lines.places[first : first + found], scale, ratios, crossings, stretches, striped
        )
        count += found
    for index in range(2 * CLASSES):
        for stretch in range(STRETCHES):
            stretches[index, stretch] *= np.float32(border.length)
    for strength in range(CLASSES):
        striped[strength] *= np.float32(border.length)
    return count * border.length


@compiled_inside
def _add_ratios(
    places: FloatArray,
    scale: StretchScale,
    ratios: Float32Array,
    crossings: Crossings,
    stretches: Float32Array,
    striped: Float32Array,
) -> None:
    """Add the ratios of crossings to the sums (8, `STRETCHES`) of their border.

    And to those of a striped cable (4,). `places` are those of the lines that it crosses.
    """
    cells, where, count = crossings.pixels[0], crossings.pixels[1], len(places)
    for index in range(padded_count(count)):
        cells[index] = point_cell(
            crossings.responses[index], crossings.slopes[index], crossings.contrasts[index]
        )
    for index in range(count):
        where[index] = np.uint32(stretch_at(scale, places[index]))
    w, x, y, z = np.float32(0.0), np.float32(0.0), np.float32(0.0), np.float32(0.0)
    index = 0
    while index < count:
        stretch = where[index]
        # As variables, they stay in registers; an array might be the table.
        a, b, c, d = np.float32(0.0), np.float32(0.0), np.float32(0.0), np.float32(0.0)
        e, f, g, h = np.float32(0.0), np.float32(0.0), np.float32(0.0), np.float32(0.0)
        while index < count and where[index] == stretch:
            of_point = ratios[np.uint64(cells[index])]
            a += of_point[0]
            b += of_point[1]
            c += of_point[2]
            d += of_point[3]
            e += of_point[4]
            f += of_point[5]
            g += of_point[6]
            h += of_point[7]
            w += either_log_ratio(of_point[0], of_point[4])
            x += either_log_ratio(of_point[1], of_point[5])
            y += either_log_ratio(of_point[2], of_point[6])
            z += either_log_ratio(of_point[3], of_point[7])
            index += 1
        sums = stretches[:, np.uint64(stretch)]
        sums[0] += a
        sums[1] += b
        sums[2] += c
        sums[3] += d
        sums[4] += e
        sums[5] += f
        sums[6] += g
        sums[7] += h
    striped[0] += w
    striped[1] += x
    striped[2] += y
    striped[3] += z


@compiled_inside
def has_stretch(stretches: int, stretch: int) -> bool:
    """Tell whether a stretch is one of some: bit k of them is stretch k."""
    return (stretches >> stretch) & 1 == 1


@compiled_inside
def either_log_ratio(bright: np.float32, dark: np.float32) -> np.float32:
    """Return the log-likelihood ratio of a point that is bright or dark, both as likely [nats].

    It is the larger of two lower bounds of the logarithm of the mean of the ratios, which are off
    by at most 0.23 nats together.
    """
    return max(HALF * (bright + dark), max(bright, dark) - LOG_2)


@compiled_inside
def sum_stretches(
    stretches: Float32Array,
    striped: Float32Array,
    cost: float,
    covered_cost: float,
    sums: Float32Array,
    reversed_ones: IndexArray,
    covered_ones: IndexArray,
) -> None:
    """Add up the ratios of the stretches of a cable.

    None of a cable with reversed stretches is covered.

    Parameters
    ----------
    stretches : Float32Array
        Sums of both borders, not tempered, by polarity and class of strength, shape
        (2, 8, `STRETCHES`) [nats]; 0 where no border is in view.
    striped : Float32Array
        Sums of both borders of a striped cable by class of strength, shape (2, 4) [nats].
    cost : float
        What it costs that a stretch is reversed, or that the cable is striped, not tempered [nats].
    covered_cost : float
        What it costs that an end is covered, see `leave_out_covered_end`, not tempered [nats].
    sums : Float32Array
        Is filled in with those along each border, shape (2, 8).
    reversed_ones : IndexArray
        Is filled in with the reversed stretches of a bright and of a dark cable, by the class of
        strength that is likeliest for both borders, shape (2,): bit k is stretch k.
    covered_ones : IndexArray
        Is filled in with the stretches of a covered end, likewise.
    """
    each = np.float32(0.5 * cost)
    for polarity in range(2):
        most = np.float32(0.0)
        for strength in range(CLASSES):
            own, other = polarity * CLASSES + strength, (1 - polarity) * CLASSES + strength
            found, covered = 0, 0
            if _fill_plain_sums(stretches, own, other, sums) > np.float32(cost):
                found = max(_reversed_stretches(stretches, own, other, each), 0)
                if found > 0:
                    _fill_reversed_sums(stretches, own, other, each, found, sums)
            if found == 0:
                covered = leave_out_covered_end(stretches[:, own], covered_cost, sums[:, own])
            both = sums[0, own] + sums[1, own]
            either = striped[0, strength] + striped[1, strength] - np.float32(cost)
            if either > both:
                turned = _reversed_stretches(stretches, own, other, np.float32(0.0))
                if turned >= 0:
                    both, found, covered = either, turned, 0
                    sums[0, own] = striped[0, strength] - each
                    sums[1, own] = striped[1, strength] - each
            if strength == 0 or both > most:
                most, reversed_ones[polarity], covered_ones[polarity] = both, found, covered


@compiled_loop
def _reversed_stretches(stretches: Float32Array, own: int, other: int, each: np.float32) -> int:
    """Return the stretches that are likelier of the other polarity; -1: most of a cable is.

    `own` and `other` are the columns of both polarities, `each` is the cost at each border [nats].
    """
    # In the width of the ratios and without branches, the processor looks at many at a time.
    found, reversals, in_view = np.int32(0), np.int32(0), np.int32(0)
    for stretch in range(STRETCHES):
        plain = stretches[0, own, stretch] + stretches[1, own, stretch]
        turned = (stretches[0, other, stretch] - each) + (stretches[1, other, stretch] - each)
        is_turned = np.int32(turned > plain)
        found = np.int32(found | (is_turned << np.int32(stretch)))
        reversals = np.int32(reversals + is_turned)
        in_view = np.int32(in_view + np.int32(plain != np.float32(0.0)))
    return -1 if 2 * reversals > in_view else int(found)


@compiled_fast_loop
def _fill_plain_sums(
    stretches: Float32Array, own: int, other: int, sums: Float32Array
) -> np.float32:
    """Fill in the sums (2, 8) of a cable of one polarity; return the most that a stretch can gain.

    `own` and `other` are the columns of both polarities.
    """
    left, right, gain = np.float32(0.0), np.float32(0.0), np.float32(0.0)
    for stretch in range(STRETCHES):
        left_own, right_own = stretches[0, own, stretch], stretches[1, own, stretch]
        left += left_own
        right += right_own
        turned = stretches[0, other, stretch] + stretches[1, other, stretch]
        gain = max(gain, turned - (left_own + right_own))
    sums[0, own], sums[1, own] = left, right
    return gain


@compiled_loop
def _fill_reversed_sums(
    stretches: Float32Array,
    own: int,
    other: int,
    each: np.float32,
    reversed_ones: int,
    sums: Float32Array,
) -> None:
    """Fill in the sums (2, 8) of a cable some of whose stretches are reversed.

    `own`, `other` and `each` are those of `_reversed_stretches`.
    """
    left, right = np.float32(0.0), np.float32(0.0)
    for stretch in range(STRETCHES):
        if has_stretch(reversed_ones, stretch):
            left += stretches[0, other, stretch] - each
            right += stretches[1, other, stretch] - each
        else:
            left += stretches[0, own, stretch]
            right += stretches[1, own, stretch]
    sums[0, own], sums[1, own] = left, right


@compiled_loop
def leave_out_covered_end(stretches: Float32Array, cost: float, sums: Float32Array) -> int:
    """Take the stretches of a covered end out of the sums, if there is one.

    Returned is without which the cable is to be looked at: bit k is stretch k; 0 if there is no
    covered end, or more of what is in view is covered than `MOST_UNSEEN`.

    Parameters
    ----------
    stretches : Float32Array
        Sums of both borders for one polarity and class of strength, not tempered, shape (2, S)
        [nats]; 0 where no border is in view.
    cost : float
        What it costs that an end is covered, not tempered [nats].
    sums : Float32Array
        Those along each border, shape (2,).
    """
    from_last = stretches[:, ::-1]
    in_view = _in_view(stretches)
    most = in_view - max((in_view + SHOWN_PART - 1) // SHOWN_PART, LEAST_SHOWN)
    first_ones, ratio = _first_covered(stretches, most, np.float32(-cost))
    last_ones, _ = _first_covered(from_last, most, ratio)
    # The last ones are covered only if they speak against the cable by more than the first ones.
    end, covered = (from_last, last_ones) if last_ones else (stretches, first_ones)
    if covered == 0:
        return 0
    for border in range(2):
        for stretch in range(covered):
            sums[border] -= end[border, stretch]
        sums[border] -= np.float32(0.5 * cost)
    if _in_view(end[:, :covered]) > MOST_UNSEEN * in_view:
        return 0
    ones: int = (1 << covered) - 1
    return ones << (stretches.shape[1] - covered) if last_ones else ones


@compiled_loop
def _in_view(stretches: Float32Array) -> int:
    """Return how many of the stretches are in view."""
    in_view = 0
    for stretch in range(stretches.shape[1]):
        both = stretches[0, stretch] + stretches[1, stretch]
        in_view += 1 if both != np.float32(0.0) else 0
    return in_view


@compiled_loop
def _first_covered(stretches: Float32Array, most: int, least: np.float32) -> tuple[int, np.float32]:
    """Return how many stretches from the first on are covered, and their sum [nats].

    That speaks against the cable by the most, and is below `least`; else none are, and `least` is
    returned. `most`: how many of those in view may be.
    """
    covered, seen, total = 0, 0, np.float32(0.0)
    for stretch in range(stretches.shape[1]):
        both = stretches[0, stretch] + stretches[1, stretch]
        seen += 1 if both != np.float32(0.0) else 0
        if seen > most:
            break
        total += both
        if total < least:
            covered, least = stretch + 1, total
    return covered, least
