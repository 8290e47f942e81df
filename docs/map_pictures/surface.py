"""Coordinates of pixels on a cable, and the share of each map cell that it covers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.measure.map.cable_map import cable_map_of
from cable_tracker.cable.measure.map.map_network import CELL
from cable_tracker.cable.measure.map.map_strips import strip_shares
from cable_tracker.cable.model.geometry import border_offset
from cable_tracker.simulation.worlds.world_dive import WORLD_SIZE

ANY_WIDTH, ANY_ANGLE = (4.0, 160.0), (-90.0, 90.0)
"""Widths [px] and angles [deg] of every second cable."""


def true_map(pose: FloatArray) -> Image:
    """Return the share of each cell that is cable, float32, shape (H / 4, W / 4)."""
    width, height = WORLD_SIZE
    nothing = np.zeros((height // CELL, width // CELL), np.float32)
    if np.isnan(pose).any():
        return nothing
    where = cable_map_of(nothing, -0.5 * (width - CELL), 0.5 * (height - CELL), float(CELL))
    return strip_shares(np.concatenate([pose, np.zeros(4)]), where)


def random_pose(rng: np.random.Generator) -> FloatArray:
    """Draw the pose of a cable: d [px], alpha [rad], w [px], beta [rad]."""
    distance = rng.uniform(-0.35, 0.35) * WORLD_SIZE[0]
    is_thin = rng.random() < 0.5
    width = math.exp(rng.uniform(*np.log(ANY_WIDTH))) if is_thin else rng.uniform(*ANY_WIDTH)
    # The wider a cable is, the nearer the camera, and the more it converges.
    skew = math.radians(0.07 * width * rng.normal())
    return np.array([distance, math.radians(rng.uniform(*ANY_ANGLE)), width, skew])


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Coordinates of pixels on a cable, each float32 (H, W).

    Attributes
    ----------
    across : Image
        Coordinate across: -1 at the left border, 1 at the right one.
    along : Image
        Coordinate along the centre line [px].
    outside : Image
        Distance outwards of the nearer border, below 0 inside [px].
    width : float
        Width w of the cable [px].
    """

    across: Image
    along: Image
    outside: Image
    width: float


def surface(pose: FloatArray, shape: tuple[int, ...]) -> Surface:
    """Return the coordinates of the pixels of a picture (H, W) on the cable of a pose (4,)."""
    distance, angle, width, skew = pose
    height, columns = shape
    x = np.arange(columns, dtype=np.float32) - np.float32(0.5 * (columns - 1))
    y = np.float32(0.5 * (height - 1)) - np.arange(height, dtype=np.float32)[:, None]
    inwards = []
    for side in (-1.0, 1.0):
        normal = angle + side * skew
        offset = border_offset(distance, width, skew, side)
        inwards.append(side * (offset - x * math.cos(normal) - y * math.sin(normal)))
    left, right = inwards
    across = (left - right) / np.maximum(np.abs(left) + np.abs(right), 1.0)
    along = y * math.cos(angle) - x * math.sin(angle)
    return Surface(
        across.astype(np.float32), along.astype(np.float32), -np.minimum(left, right), float(width)
    )


def roughen(at: Surface, rng: np.random.Generator) -> Image:
    """Return `outside` [px] with borders roughened at random."""
    rough = coarse_noise(at.outside.shape, (40, 53), rng)
    return np.asarray(at.outside + np.float32(0.15 * at.width * rng.random() ** 2) * rough)


def coarse_noise(
    shape: tuple[int, ...], coarse: tuple[int, int], rng: np.random.Generator
) -> Image:
    """Return Gaussian noise of a `coarse` shape, interpolated to a shape (H, W)."""
    return cv2.resize(rng.standard_normal(coarse, np.float32), shape[::-1])


def nearest_random_point(
    count: int, side: int, rng: np.random.Generator
) -> tuple[Image, IndexArray]:
    """Return the distance of pixels (side, side) from the nearest random point, and its number."""
    apart = np.ones((side, side), np.uint8)
    points = rng.integers(0, side, (count, 2))
    apart[points[:, 1], points[:, 0]] = 0
    return cv2.distanceTransformWithLabels(
        apart, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )


def shares_at_pixels(cells: Image, shape: tuple[int, ...]) -> Image:
    """Return shares of cells (H / 4, W / 4) interpolated to the pixels (H, W)."""
    return cv2.resize(cells, shape[::-1], interpolation=cv2.INTER_LINEAR)


def logistic(values: Image) -> Image:
    """Return a ramp from 0 to 1 about 0."""
    ramp: Image = 1.0 / (1.0 + np.exp(np.clip(-values, -20.0, 20.0)))
    return ramp
