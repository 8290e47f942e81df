"""Cables that are bright in some places and dark in others: painted bands, growth, another bottom.

The picture is divided into stretches along the cable. One whose borders both say that it is of the
other polarity is counted as such, at a cost: without the cost, anything would be a cable that
changes often enough. Most of a bright cable is bright, or a shadow would be one, too.

Shorter bands are those of a *striped* cable: each point of its borders is bright or dark, whatever
its neighbours are. That costs as much as one reversed stretch, and a point whose polarity is clear
says ln 2 less. Strands are not found so: their edges run askew to the border.

A cost for each band, whatever its length, was tried in place of one for each stretch: of the banded
cables of the worlds to tune on fewer were found, and no other world was the better for it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import Float32Array, FloatArray, IndexArray
from cable_tracker.cable.measure.borders.border_points import BorderLine
from cable_tracker.cable.measure.borders.covered_end import leave_out_covered_end
from cable_tracker.cable.measure.borders.response_bins import CLASSES
from cable_tracker.cable.measure.gradients.scanned_gradients import ScanInputs
from cable_tracker.cable.model.state import ANGLE
from cable_tracker.compilation import compiled_fast_loop, compiled_inside, compiled_loop

HALF = np.float32(0.5)
LOG_2 = np.float32(math.log(2.0))

STRETCHES = 16
"""Number of stretches of a cable along the diagonal of the picture."""


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
