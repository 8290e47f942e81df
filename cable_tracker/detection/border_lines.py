"""Straight lines through edge points: candidates for the borders of a cable.

A border is written with its normal pointing to the brighter side, so that the two borders of a
strip have opposite normals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.model.geometry import segment_inside
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH
from cable_tracker.detection.edges import EdgePoints

FIT_TOLERANCES = (4.0, 2.5, 2.0)
"""How far a point may lie from its line, at one fit after the other [px at the reference width]."""

DIRECTION_TOLERANCE = float(np.deg2rad(20.0))
"""How far the gradient at a point may be turned from the normal of its line."""

MINIMUM_POINTS = 6
"""A line through fewer points is none."""

CONTRAST_CAP = 6.0
"""Contrast above which an edge counts no more: a lamp's glint must not outweigh a long border."""

STRETCH = 4.0
"""Length of the stretches of a line that are covered or not [px at the reference width]."""

SAME_OFFSET = 4.0
SAME_ANGLE = float(np.deg2rad(4.0))
"""Lines as close as this are one [px at the reference width, rad]."""


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


def turn_between(angles: FloatArray, reference: FloatArray) -> FloatArray:
    """Return the turn from reference to angles, in [-pi, pi)."""
    turn: FloatArray = np.mod(angles - reference + np.pi, 2 * np.pi) - np.pi
    return turn


def fit_lines(
    angles: FloatArray, offsets: FloatArray, points: EdgePoints, image_size: tuple[int, int]
) -> BorderLines:
    """Draw lines to the edge points about them, and merge those that become the same.

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
    scale = image_size[0] / REFERENCE_WIDTH
    for tolerance in FIT_TOLERANCES:
        members = _members(angles, offsets, points, tolerance * scale)
        enough = np.count_nonzero(members, axis=1) >= MINIMUM_POINTS
        angles, offsets = _total_least_squares(angles[enough], members[enough], points)
    members = _members(angles, offsets, points, FIT_TOLERANCES[-1] * scale)
    supports = _supports(angles, offsets, members, points, image_size)
    return _merged(BorderLines(angles, offsets, supports), scale)


def _members(
    angles: FloatArray, offsets: FloatArray, points: EdgePoints, tolerance: float
) -> FloatArray:
    """Return the weight of each point in each line, shape (N, P); 0 if it does not belong there."""
    normals = np.stack((np.cos(angles), np.sin(angles)), axis=0)
    residuals = points.positions @ normals - offsets
    gradients = np.stack((np.cos(points.directions), np.sin(points.directions)), axis=1)
    aligned = gradients @ normals >= np.cos(DIRECTION_TOLERANCE)
    belongs = aligned & (np.abs(residuals) <= tolerance)
    weights: FloatArray = np.where(belongs, np.minimum(points.contrasts, CONTRAST_CAP)[:, None], 0)
    return weights.T


def _total_least_squares(
    angles: FloatArray, members: FloatArray, points: EdgePoints
) -> tuple[FloatArray, FloatArray]:
    """Return angles and offsets (N,) of the lines through weighted points (N, P)."""
    x, y = points.positions[:, 0], points.positions[:, 1]
    products = np.stack((np.ones_like(x), x, y, x * x, x * y, y * y), axis=1)
    moments = members @ products
    total, mean_x, mean_y, xx, xy, yy = np.moveaxis(moments, 1, 0)
    mean_x, mean_y = mean_x / total, mean_y / total
    xx, xy, yy = (
        xx / total - mean_x**2,
        xy / total - mean_x * mean_y,
        yy / total - mean_y**2,
    )
    fitted = 0.5 * np.arctan2(2 * xy, xx - yy) + np.pi / 2
    turned = np.abs(turn_between(fitted, angles)) > np.pi / 2
    fitted = np.where(turned, fitted + np.pi, fitted)
    return fitted, mean_x * np.cos(fitted) + mean_y * np.sin(fitted)


def _supports(
    angles: FloatArray,
    offsets: FloatArray,
    members: FloatArray,
    points: EdgePoints,
    image_size: tuple[int, int],
) -> FloatArray:
    """Return the share of each line's visible length that points cover, weighted by contrast.

    A line that only cuts a corner must not win because it is short: it is taken to be at least half
    as long as the smaller side of the picture.
    """
    stretch = max(STRETCH * image_size[0] / REFERENCE_WIDTH, 1.0)
    reach = int(np.hypot(*image_size) / 2 / stretch) + 1
    along = points.positions @ np.stack((-np.sin(angles), np.cos(angles)), axis=0)
    stretches = np.clip(np.floor(along / stretch).astype(np.int64) + reach, 0, 2 * reach)
    best = np.zeros((len(angles), 2 * reach + 1))
    lines, indices = np.nonzero(members)
    np.maximum.at(best, (lines, stretches[indices, lines]), members[lines, indices])
    lengths = np.array(
        [
            visible_length(angle, offset, image_size)
            for angle, offset in zip(angles, offsets, strict=True)
        ]
    )
    lengths = np.maximum(lengths, min(image_size) / 2)
    shares: FloatArray = best.sum(axis=1) / CONTRAST_CAP * stretch / lengths
    return np.minimum(shares, 1.0)


def visible_length(angle: float, offset: float, image_size: tuple[int, int]) -> float:
    """Return the length of a line inside the picture [px]; 0 if it does not cross it."""
    ends = segment_inside(angle, offset, image_size)
    if ends is None:
        return 0.0
    return float(np.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]))


def _merged(lines: BorderLines, scale: float) -> BorderLines:
    """Keep the best supported of lines that are the same, best first."""
    lines = lines.taken(np.argsort(-lines.supports, kind="stable"))
    turns = turn_between(lines.angles[:, None], lines.angles[None, :])
    shifts = lines.offsets[:, None] - lines.offsets[None, :]
    same = (np.abs(turns) < SAME_ANGLE) & (np.abs(shifts) < SAME_OFFSET * scale)
    kept: list[int] = []
    for index in range(len(lines)):
        if not same[index, kept].any():
            kept.append(index)
    return lines.taken(np.array(kept, dtype=np.int64))
