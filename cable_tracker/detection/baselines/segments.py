"""Straight segments of edges, and the border lines they add up to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image, IndexArray
from cable_tracker.detection.border_lines import BorderLines, EdgePoints, Gradient, fit_lines
from cable_tracker.detection.search_region import SearchRegion
from cable_tracker.tracking.image_frame import image_to_pixel

SAMPLE_SPACING = 2.0
"""Distance of the points that stand for a segment [px]."""

MOST_SEEDS = 40
"""Number of segments, the longest, from which a line is begun."""


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """N straight segments.

    Attributes
    ----------
    starts, ends : FloatArray
        Ends in the image frame [px], shape (N, 2).
    """

    starts: FloatArray
    ends: FloatArray

    def __len__(self) -> int:
        return len(self.starts)

    @property
    def lengths(self) -> FloatArray:
        """Lengths [px], shape (N,)."""
        span = self.ends - self.starts
        return np.hypot(span[:, 0], span[:, 1])

    def selected(self, chosen: BoolArray) -> Segments:
        """Return the segments of a mask of shape (N,)."""
        return Segments(self.starts[chosen], self.ends[chosen])

    def within(self, region: SearchRegion | None) -> Segments:
        """Return those that may be on a border of a cable in a region; all of them without one."""
        if region is None:
            return self
        return self.selected(region.covers(self.starts) & region.covers(self.ends))


def lines_of_segments(
    segments: Segments, gradient: Gradient, minimum_contrast: float
) -> BorderLines:
    """Join segments that lie on one line with the same contrast, however far apart.

    Parameters
    ----------
    segments : Segments
        Pieces of edges.
    gradient : Gradient
        Gradient of the picture, which tells the brighter side and the contrast.
    minimum_contrast : float
        Fainter segments are left out [frame's scale].
    """
    image_size = (gradient.modulus.shape[1], gradient.modulus.shape[0])
    owners, points = _sample(segments, gradient)
    count = len(segments)
    signed = np.bincount(owners, points.contrasts, count) / np.bincount(owners, minlength=count)
    normals = _normal_angles(segments) + np.where(signed < 0, np.pi, 0.0)
    contrasts = np.abs(signed)
    clear = contrasts >= minimum_contrast
    points = EdgePoints(points.positions, normals[owners], contrasts[owners])
    points = points.selected(clear[owners])
    seeds = np.argsort(-segments.lengths * clear, kind="stable")[:MOST_SEEDS]
    seeds = seeds[clear[seeds]]
    middles = (segments.starts[seeds] + segments.ends[seeds]) / 2
    angles = normals[seeds]
    offsets = middles[:, 0] * np.cos(angles) + middles[:, 1] * np.sin(angles)
    return fit_lines(angles, offsets, points, image_size)


def _normal_angles(segments: Segments) -> FloatArray:
    span = segments.ends - segments.starts
    normals: FloatArray = np.arctan2(span[:, 1], span[:, 0]) + np.pi / 2
    return normals


def _sample(segments: Segments, gradient: Gradient) -> tuple[IndexArray, EdgePoints]:
    """Place points along the segments; their contrast is that across the segment, with its sign.

    Returns
    -------
    owners : IndexArray
        The segment of each point, shape (P,).
    points : EdgePoints
        The directions are the segments' normals, whether it gets brighter or darker that way.
    """
    counts = np.maximum(np.ceil(segments.lengths / SAMPLE_SPACING), 1.0).astype(np.int64)
    owners = np.repeat(np.arange(len(segments)), counts)
    first = np.repeat(np.cumsum(counts) - counts, counts)
    part = ((np.arange(len(owners)) - first + 0.5) / counts[owners])[:, None]
    positions = segments.starts[owners] * (1 - part) + segments.ends[owners] * part
    normals = _normal_angles(segments)[owners]
    x, y = _read(gradient.x, positions), _read(gradient.y, positions)
    across = (x * np.cos(normals) + y * np.sin(normals)) / gradient.scale
    return owners, EdgePoints(positions, normals, across)


def _read(values: Image, positions: FloatArray) -> FloatArray:
    """Return the values at the pixels nearest to points of the image frame."""
    height, width = values.shape
    pixels = np.rint(image_to_pixel(positions, (width, height))).astype(np.int64)
    columns, rows = np.clip(pixels[:, 0], 0, width - 1), np.clip(pixels[:, 1], 0, height - 1)
    read: FloatArray = values[rows, columns].astype(np.float64)
    return read
