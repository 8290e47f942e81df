"""Detectors of targets: outlines of all that stands out from a picture."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import cv2
import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray
from cable_tracker.contour.evolution import ContourSettings, evolve
from cable_tracker.contour.fast_marching import arrival_times, edge_speed
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.tracking.robust import GAUSSIAN_MAD

TILE = 30
"""Distance between seeds [px] (Ha, chapter 7)."""

SEED_RADIUS = 8
"""Radius of the disc that a contour starts from [px]."""

ITERATIONS = 12
"""Largest number of iterations of a seed's contour."""

LEAST_CONTRAST = 0.12
"""Difference of the means of an accepted contour, intensities being 0 to 1."""

LEAST_SHARE, MOST_SHARE = 0.0008, 0.3
"""Limits of the share of the picture that a proposed outline fills."""

LEAST_WORTH = 0.03
"""Minimum worth of a candidate: that of texture alone stays below."""

LEAST_SOLIDITY = 0.75
"""Minimum share of a proposed outline's area in that of its convex hull."""

MARCH_TIME, MARCH_GAIN, MARCH_SIGMA = 1.6, 25.0, 1.2
"""Arrival in widths of the picture after which what the front has not entered is enclosed; gain on
the gradient; smoothing [px]."""

SPREAD_LIMIT = 6.0
"""Upper bound of a pixel's distance from the usual colour, in deviations."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """An outline that may be a target.

    Attributes
    ----------
    mask : BoolArray
        Shape of the working image.
    worth : float
        Contrast times the root of the area's share; the larger, the sooner a target.
    """

    mask: BoolArray
    worth: float


def saliency(frame: WorkingFrame) -> NDArray[np.float32]:
    """Return the saliency of every pixel, its distance from usual values, 0 to 1, shape (H, W)."""
    channels = frame.channels[..., 1:] if frame.is_coloured else frame.channels[..., :1]
    values = cv2.GaussianBlur(channels, (0, 0), 1.5).astype(np.float32)
    if values.ndim == 2:
        values = values[..., None]
    # Light fades with depth: what is usual differs from row to row, smoothly.
    rows = np.median(values, axis=1, keepdims=True)
    usual = cv2.blur(rows, (1, 31)).reshape(rows.shape)
    apart = np.abs(values - usual)
    spread = np.maximum(GAUSSIAN_MAD * np.median(apart, axis=(0, 1)), 2.0)
    distance = np.sqrt(((apart / spread) ** 2).mean(axis=2))
    scaled: NDArray[np.float32] = np.minimum(distance / SPREAD_LIMIT, 1.0).astype(np.float32)
    return scaled


def contour_candidates(frame: WorkingFrame) -> list[Candidate]:
    """Return the outlines that contours from seeds on a grid converge to, the likeliest first."""
    map_ = saliency(frame)
    height, width = map_.shape
    rows, columns = np.mgrid[:height, :width]
    settings = ContourSettings(regulariser=0.02, balance=-1.0, iterations=ITERATIONS)
    found: list[Candidate] = []
    covered = np.zeros(map_.shape, np.bool_)
    for row in range(TILE // 2, height, TILE):
        for column in range(TILE // 2, width, TILE):
            seed = (columns - column) ** 2 + (rows - row) ** 2 <= SEED_RADIUS**2
            # A seed in what is usual, or in what has been found, leads nowhere new.
            if covered[row, column] or map_[seed].max() < 2.0 * LEAST_CONTRAST:
                continue
            contour = evolve(map_, seed, settings, by_means=True)
            if contour.contrast < LEAST_CONTRAST or contour.inside_mean < contour.outside_mean:
                continue
            for part in _parts(contour.mask):
                if not (covered & part).any():
                    found += _accepted(part, contour.contrast)
                    covered |= part
    return sorted(found, key=lambda each: -each.worth)


def marching_candidates(frame: WorkingFrame) -> list[Candidate]:
    """Return the regions that a front from the picture's borders cannot enter, likeliest first."""
    map_ = saliency(frame)
    width = map_.shape[1]
    seeds = np.zeros(map_.shape, np.bool_)
    seeds[0] = seeds[-1] = True
    seeds[:, 0] = seeds[:, -1] = True
    times = arrival_times(edge_speed(map_, MARCH_SIGMA, MARCH_GAIN), seeds, MARCH_TIME * width)
    enclosed = times > np.percentile(times, 90.0) if np.isfinite(times).all() else np.isinf(times)
    # Behind an obstacle the front comes late as well: its shadow is like the rest of the picture.
    enclosed &= map_ > map_.mean() + LEAST_CONTRAST
    found: list[Candidate] = []
    for part in _parts(enclosed):
        inside = float(map_[part].mean())
        outside = float(map_[~part].mean())
        if inside - outside >= LEAST_CONTRAST:
            found += _accepted(part, inside - outside)
    return sorted(found, key=lambda each: -each.worth)


def _parts(mask: BoolArray) -> list[BoolArray]:
    """Return the connected parts of a mask that are large enough."""
    count, labels, statistics, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    least = LEAST_SHARE * mask.size
    return [
        labels == index for index in range(1, count) if statistics[index, cv2.CC_STAT_AREA] >= least
    ]


def _accepted(mask: BoolArray, contrast: float) -> list[Candidate]:
    """Return the candidate if its shape may be that of a target."""
    share = float(mask.mean())
    touches = mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any()
    if touches or not LEAST_SHARE <= share <= MOST_SHARE:
        return []
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    hull = cv2.contourArea(cv2.convexHull(contours[0]))
    if cv2.contourArea(contours[0]) < LEAST_SOLIDITY * hull:
        return []
    worth = contrast * math.sqrt(share)
    return [Candidate(mask, worth)] if worth >= LEAST_WORTH else []


DETECTORS: Mapping[str, Callable[[WorkingFrame], list[Candidate]]] = MappingProxyType(
    {"contours": contour_candidates, "marching": marching_candidates}
)
"""By the values of the parameter `detector`."""
