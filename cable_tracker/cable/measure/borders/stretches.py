"""Cables that are bright in some places and dark in others: painted bands, growth, another bottom.

The picture is divided into stretches along the cable. One whose borders both say that it is of the
other polarity is counted as such, at a cost: without the cost, anything would be a cable that
changes often enough. Most of a bright cable is bright, or a shadow would be one, too.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import BoolArray, Float32Array, FloatArray
from cable_tracker.cable.measure.borders.border_points import BorderLine
from cable_tracker.cable.measure.borders.response_bins import CLASSES
from cable_tracker.cable.measure.gradients.scanned_gradients import ScanInputs
from cable_tracker.cable.model.state import ANGLE
from cable_tracker.compilation import compiled_fast_loop, compiled_inside

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
def stretch_scale(axis: StretchAxis, border: BorderLine, is_steep: bool) -> StretchScale:
    """Return which stretches a border of a cable is in; `is_steep`: it is measured on rows."""
    along_line, across = (axis.x, axis.y) if is_steep else (axis.y, axis.x)
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
def sum_stretches(
    stretches: Float32Array, cost: float, sums: Float32Array, is_reversed: BoolArray
) -> None:
    """Add up the ratios of the stretches of a cable.

    Parameters
    ----------
    stretches : Float32Array
        Sums of both borders, not tempered, by polarity and class of strength, shape
        (2, 8, `STRETCHES`) [nats]; 0 where no border is in view.
    cost : float
        What it costs that a stretch is reversed, not tempered [nats].
    sums : Float32Array
        Is filled in with those along each border, shape (2, 8).
    is_reversed : BoolArray
        Is filled in with the reversed stretches of a bright and of a dark cable, by the class of
        strength that is likeliest for both borders, shape (2, `STRETCHES`).
    """
    each = np.float32(0.5 * cost)
    for polarity in range(2):
        likeliest, has_bands = 0, False
        for strength in range(CLASSES):
            own, other = polarity * CLASSES + strength, (1 - polarity) * CLASSES + strength
            banded = _fill_sums(stretches, own, other, each, sums)
            best = polarity * CLASSES + likeliest
            if strength == 0 or sums[0, own] + sums[1, own] > sums[0, best] + sums[1, best]:
                likeliest, has_bands = strength, banded
        own, other = polarity * CLASSES + likeliest, (1 - polarity) * CLASSES + likeliest
        for stretch in range(STRETCHES):
            plain = stretches[0, own, stretch] + stretches[1, own, stretch]
            turned = stretches[0, other, stretch] + stretches[1, other, stretch]
            is_reversed[polarity, stretch] = has_bands and turned > plain + 2 * each


@compiled_fast_loop
def _fill_sums(
    stretches: Float32Array, own: int, other: int, each: np.float32, sums: Float32Array
) -> bool:
    """Fill in the sums (2, 8) of a polarity and class; tell whether stretches may be reversed.

    `own` and `other` are the columns of both polarities, `each` is the cost at each border [nats].
    """
    left, right = np.float32(0.0), np.float32(0.0)
    left_plain, right_plain = np.float32(0.0), np.float32(0.0)
    in_view, reversals = 0, 0
    for stretch in range(STRETCHES):
        left_own, right_own = stretches[0, own, stretch], stretches[1, own, stretch]
        left_other = stretches[0, other, stretch] - each
        right_other = stretches[1, other, stretch] - each
        is_reversed = left_other + right_other > left_own + right_own
        left_plain += left_own
        right_plain += right_own
        left += left_other if is_reversed else left_own
        right += right_other if is_reversed else right_own
        reversals += 1 if is_reversed else 0
        in_view += 1 if left_own + right_own != np.float32(0.0) else 0
    has_bands = 2 * reversals <= in_view
    sums[0, own] = left if has_bands else left_plain
    sums[1, own] = right if has_bands else right_plain
    return has_bands
