"""Weights of blobs: by the energies of their contours, (30), or near a horizon (section 6.5).

(30) stands as printed, as the sentence before it describes, and as a ratio. Near a horizon, (31) to
(34), what moves against the sky and has edges is heavy. Without a horizon or a sun in the picture,
p of (33) is 1 everywhere. How both are found is our choice: the horizon is the row where the
picture changes most, the sun the column with the most pixels that are saturated.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray, shares_of

IMAGE_SHARE = 0.5
"""l_cv of (30); that of the shape is the rest."""

SHAPE_UNIT = 25.0
"""Shape energy of weight 1/e in the other two forms [px² of an image 320 px wide]; our choice."""

ENERGY_UNIT = 1e-3
"""Image energy of weight 1/e in the product: the thesis leaves its unit open; our choice."""

RATIO_SHARPNESS = 2.0
"""Log-weight per unit of contrast over the spread, in the ratio; our choice."""

FARTHEST_SHIFT = 5
"""Largest shift by which frames are aligned [px]."""

EDGE_SHARE = 0.5
"""l_e of (34); that of the movement is the rest."""

HORIZON_REACH, HORIZON_COST = 1, 0.5
"""(33): within a pixel of the horizon half the edges are the horizon's."""

SUN_REACH, SUN_COST = 7, 1.0
"""(33): distance from the sun's column within which edges are the sun's [px], and their share."""

SATURATED, LEAST_SATURATED = 0.98, 4
"""Intensity of a pixel of the sun, and how many of them its column has at least."""

LEAST_STEP = 0.15
"""Mean step between rows that makes a horizon."""


def blob_weights(
    image_energies: FloatArray, shape_energies: FloatArray, contrasts: FloatArray, form: str
) -> FloatArray:
    """Return the weights of N blobs, summing to one.

    Parameters
    ----------
    image_energies, shape_energies : FloatArray
        E_cv per pixel and E_S [px² of an image 320 px wide], shape (N,); infinite where there is no
        contour.
    contrasts : FloatArray
        Differences of the means.
    form : str
        `eq30`: l_cv e^-E_cv / sum + l_s (1 - E_S / sum E_S), which gives the image hardly a share;
        `product`: e^-E_cv e^-E_S; `likelihood_ratio`: two regions against one, that is the contrast
        over the spread that the two means leave.
    """
    possible = np.isfinite(image_energies) & np.isfinite(shape_energies)
    if not possible.any():
        return np.full(len(possible), 1.0 / len(possible))
    image, shape = image_energies[possible], shape_energies[possible]
    weights = np.zeros(len(possible))
    if form == "eq30":
        likely = np.exp(-image)
        weights[possible] = IMAGE_SHARE * likely / likely.sum()
        total = shape.sum()
        unlike = shape / total if total > 0.0 else np.zeros_like(shape)
        weights[possible] += (1.0 - IMAGE_SHARE) * (1.0 - unlike)
    else:
        logs = -shape / SHAPE_UNIT
        if form == "product":
            logs = logs - image / ENERGY_UNIT
        else:
            logs = logs + RATIO_SHARPNESS * contrasts[possible] / np.sqrt(image + ENERGY_UNIT)
        weights[possible] = np.exp(logs - logs.max())
    shares: FloatArray = weights / weights.sum()
    return shares


def alignment(now: NDArray[np.float32], before: NDArray[np.float32]) -> tuple[int, int]:
    """Return the shift (columns, rows) of the picture since the frame before.

    Two rows and two columns are compared, at thirds of the picture, for shifts of -5 to 5 px, or as
    many as leave something to compare of a low picture.
    """
    height, width = now.shape
    rows, columns = (height // 3, 2 * height // 3), (width // 3, 2 * width // 3)
    across = _best_shift([(now[row], before[row]) for row in rows])
    down = _best_shift([(now[:, column], before[:, column]) for column in columns])
    return across, down


def _best_shift(pairs: list[tuple[NDArray[np.float32], NDArray[np.float32]]]) -> int:
    reach = min(FARTHEST_SHIFT, (len(pairs[0][0]) - 1) // 2)
    best, least = 0, math.inf
    # Small shifts first: of equal ones the smallest.
    for shift in sorted(range(-reach, reach + 1), key=abs):
        error = sum(
            float(((now[reach:-reach] - np.roll(before, shift)[reach:-reach]) ** 2).mean())
            for now, before in pairs
        )
        if error < least:
            best, least = shift, error
    return best


def roberts_energy(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the squared Roberts cross at every pixel (32); zero in the last row and column."""
    energy = np.zeros_like(image)
    energy[:-1, :-1] = (image[:-1, :-1] - image[1:, 1:]) ** 2
    energy[:-1, :-1] += (image[:-1, 1:] - image[1:, :-1]) ** 2
    return energy


def horizon_row(image: NDArray[np.float32]) -> int | None:
    """Return the row of the horizon: the largest step between rows; None if it is small."""
    means = image.mean(axis=1)
    steps = np.abs(np.diff(means))
    row = int(np.argmax(steps))
    return row if float(steps[row]) >= LEAST_STEP else None


def sun_column(image: NDArray[np.float32]) -> int | None:
    """Return the column of the sun: that with the most saturated pixels; None if there are few.

    Of several with as many it is the one in their middle.
    """
    counts = np.count_nonzero(image >= SATURATED, axis=0)
    most = int(counts.max())
    if most < LEAST_SATURATED:
        return None
    return round(float(np.flatnonzero(counts == most).mean()))


def edge_shares(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return p of (33) at every pixel: how much of an edge there may be a target's."""
    shares = np.ones_like(image)
    row, column = horizon_row(image), sun_column(image)
    if row is not None:
        shares[max(row - HORIZON_REACH, 0) : row + HORIZON_REACH + 1] = 1.0 - HORIZON_COST
    if column is not None:
        shares[:, max(column - SUN_REACH, 0) : column + SUN_REACH + 1] = 1.0 - SUN_COST
    return shares


def horizon_weights(
    now: NDArray[np.float32],
    before: NDArray[np.float32],
    mask: BoolArray,
    corners: list[tuple[int, int]],
) -> FloatArray:
    """Return the weights (34) of blobs, shape (N,), summing to one.

    Parameters
    ----------
    now, before : array
        Intensities of this frame and of the one before, float32, shape (H, W).
    mask : BoolArray
        The blob in its window.
    corners : list of (int, int)
        Column and row of every particle's window.
    """
    across, down = alignment(now, before)
    moving = (now - np.roll(before, (down, across), axis=(0, 1))) ** 2
    edges = roberts_energy(now) * edge_shares(now)
    edge_sums = np.array([_sum_in(edges, mask, corner) for corner in corners])
    moving_sums = np.array([_sum_in(moving, mask, corner) for corner in corners])
    return EDGE_SHARE * shares_of(edge_sums) + (1.0 - EDGE_SHARE) * shares_of(moving_sums)


def _sum_in(values: NDArray[np.float32], mask: BoolArray, corner: tuple[int, int]) -> float:
    column, row = corner
    height, width = mask.shape
    left, top = max(column, 0), max(row, 0)
    right = min(column + width, values.shape[1])
    bottom = min(row + height, values.shape[0])
    if right <= left or bottom <= top:
        return 0.0
    part = mask[top - row : bottom - row, left - column : right - column]
    return float(values[top:bottom, left:right][part].sum())
