"""How a cable bends, and the picture with it made straight.

The state is a straight strip. A thin cable that curves by more than its width fits none, however
clear it is; where the map shows such a curve, the picture is straightened about it before anything
is measured. The straight line of least squares through the cable stays where it is, so d and alpha
are those of this line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.polynomial.legendre import legvander

from cable_tracker.arrays import FloatArray, Image

MARKED = 0.5
"""Probability from which on a cell counts as cable."""

GATES = (24.0, 12.0, 6.0)
"""Distances from the curve so far within which cells count for the next one [cells]."""

FEWEST_LINES = 0.7
"""Share of the lines of cells, at least, on which a curve must be marked."""

LEAST_ON_CURVE = 0.9
"""Share of the marked cells, at least, that must lie within the last gate: a map that shows more
than one cable may show a curve through several things."""

ROUGHEST, ROUGHEST_SHARE = 0.35, 0.1
"""Root mean square of what a curve leaves unexplained, at most: [cells] + share of the width."""

LEAST_BEND, NARROWEST = 0.5, 2.0
"""Amplitude below which a cable counts as straight, in widths, and width that it is taken to have
at least [cells]: a map blurs, and growth on one side bends its middle."""


@dataclass(frozen=True, slots=True)
class Bend:
    """How far a cable lies beside its straight line of least squares.

    At t, from -1 to 1 across the picture, it lies `amplitude` (3 t^2 - 1) / 2 to the right of, or
    below, the line.

    Attributes
    ----------
    amplitude : float
        In widths of the picture.
    is_steep : bool
        Whether t runs from the top to the bottom and the cable is displaced to the right, else
        from the left to the right and downwards.
    """

    amplitude: float
    is_steep: bool = True

    def displacements(self, count: int, width: float) -> FloatArray:
        """Return the displacements at evenly spaced middles of `count` lines, shape (count,).

        They are in the unit of `width`, the picture's.
        """
        displacements: FloatArray = self.amplitude * width * _legendre_terms(count)[:, 2]
        return displacements


STRAIGHT = Bend(0.0)

LEAST_KEPT = 0.001
"""Amplitude below which a bend that is no longer found has ended, a third of a pixel of 320."""


def straightened(picture: Image, bend: Bend) -> Image:
    """Return a picture (h, w), uint8 or float32, with the bend taken out.

    Beyond its sides the outermost levels go on.
    """
    height, width = picture.shape
    x, y = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    if bend.is_steep:
        x += bend.displacements(height, width).astype(np.float32)[:, None]
    else:
        y += bend.displacements(width, width).astype(np.float32)
    border = cv2.BORDER_REPLICATE
    return np.asarray(cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=border))


def bend_of_map(probabilities: Image) -> Bend:
    """Return the bend of the one cable that a map shows, shape (rows, columns).

    `STRAIGHT` where it shows none, several, or one that may as well be straight.
    """
    cells = np.where(probabilities >= MARKED, probabilities, 0.0).astype(np.float64)
    if not cells.any():
        return STRAIGHT
    is_steep = _is_steep(cells)
    lines = cells if is_steep else cells.T
    count, length = lines.shape
    terms = _legendre_terms(count)
    curve = _straight_line(lines, terms)
    for gate in GATES:
        near = lines * (np.abs(np.arange(length) - curve[:, None]) <= gate)
        widths = near.sum(axis=1)
        marked = widths > 0.0
        if np.count_nonzero(marked) < max(FEWEST_LINES * count, terms.shape[1]):
            return STRAIGHT
        middles = (near @ np.arange(length))[marked] / widths[marked]
        coefficients, *_ = np.linalg.lstsq(terms[marked], middles, rcond=None)
        curve = terms @ coefficients
    if near.sum() < LEAST_ON_CURVE * lines.sum():
        return STRAIGHT
    width = max(float(np.median(widths[marked])), NARROWEST)
    unexplained = math.sqrt(float(np.mean((middles - curve[marked]) ** 2)))
    least, amplitude = LEAST_BEND * width, float(coefficients[2])
    if abs(amplitude) <= least or unexplained > ROUGHEST + ROUGHEST_SHARE * width:
        return STRAIGHT
    # Without a jump where a straight cable begins to bend.
    amplitude *= 1.0 - (least / amplitude) ** 2
    return Bend(amplitude / probabilities.shape[1], is_steep)


def bend_after(before: Bend, found: Bend) -> Bend:
    """Return the bend to go on with: the mean of those before and found, or all of a new one.

    Where none is found, half of the one before, of either direction, until it is too small to see.
    """
    if found == STRAIGHT:
        half = 0.5 * before.amplitude
        return Bend(half, before.is_steep) if abs(half) >= LEAST_KEPT else STRAIGHT
    if before == STRAIGHT or before.is_steep != found.is_steep:
        return found
    return Bend(0.5 * (before.amplitude + found.amplitude), found.is_steep)


def _legendre_terms(count: int) -> FloatArray:
    """Return Legendre's polynomials of degree 0 to 2 at the middles of lines, shape (count, 3).

    The lines lie side by side and fill -1 to 1. The line of least squares through degree 2 is zero.
    """
    return legvander((2.0 * np.arange(count) + 1.0) / count - 1.0, 2).astype(np.float64)


def _is_steep(cells: FloatArray) -> bool:
    """Tell whether marked cells lie rather one above the other than side by side."""
    rows, columns = np.nonzero(cells)
    return bool(rows.var() >= columns.var())


def _straight_line(lines: FloatArray, terms: FloatArray) -> FloatArray:
    """Return the line of least squares through the marked cells of some lines, shape (lines,)."""
    line, place = np.nonzero(lines)
    coefficients, *_ = np.linalg.lstsq(terms[line, :2], place.astype(np.float64), rcond=None)
    return np.asarray(terms[:, :2] @ coefficients)
