"""The learnt observation model: how much likelier a frame is with a cable than without.

Along each border, at regular points, the response across the border and its slope are looked up in
a table of log-likelihood ratios, border against background. A border that is overgrown at a point
costs a bounded amount there. Neighbouring points are not independent, so the sum is tempered.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image
from cable_tracker.cable.geometry import (
    Borders,
    image_to_pixel,
    project_borders,
    sample_points,
)
from cable_tracker.cable.gradients import read_channels
from cable_tracker.cable.parameters import REFERENCE_WIDTH, TrackerParameters
from cable_tracker.cable.response_table import PointMeasures, ResponseTable, load_table
from cable_tracker.cable.working_image import WorkingImage

CABLES_AT_ONCE = 512
"""Cables measured in one go, so that it all stays in the cache and memory does not grow with N."""

TEMPERED_SPACING = 5.0
"""Spacing of the points that the parameter `tempering` is given for [px at the reference width]."""

BEHIND = 0.25
"""The inside is looked at so deep behind the border, as a share of the cable's width ..."""

NEAREST, FARTHEST_BEHIND, FARTHEST_MIDDLE = 3.0, 12.0, 40.0
"""... and in the middle, within these limits [px at the reference width]."""

OUTSIDE = 6.0
"""The outside is looked at so far from the border [px at the reference width]."""

SMALLEST_RESPONSE = 1.0
"""Added to a response before its slope is divided by it [robust scales]: noise has no ridge."""


@dataclass(frozen=True, slots=True, eq=False)
class CableEvidence:
    """What a frame says about each of N cables, bright ones in column 0, dark ones in column 1.

    Attributes
    ----------
    log_ratios : FloatArray
        Tempered log-likelihood ratio, cable against no cable, shape (N, 2).
    weaker_borders : FloatArray
        Mean log-likelihood ratio per point of the weaker border, not tempered, shape (N, 2).
    seen : FloatArray
        Number of points inside the image of the border that has fewer, shape (N,).
    """

    log_ratios: FloatArray
    weaker_borders: FloatArray
    seen: FloatArray

    def joined(self, other: CableEvidence) -> CableEvidence:
        """Return the evidence on these cables and then on others."""
        return CableEvidence(
            np.concatenate((self.log_ratios, other.log_ratios)),
            np.concatenate((self.weaker_borders, other.weaker_borders)),
            np.concatenate((self.seen, other.seen)),
        )


class BorderLikelihoodRatio:
    """Likelihood of a frame given a cable over that given none.

    Parameters
    ----------
    parameters : TrackerParameters
        Spacing, tempering, cost of missing points.
    table : ResponseTable or None
        Ratios of single points; None: those of the file that the parameters name.

    Raises
    ------
    ParameterError
        The file cannot be read.
    """

    def __init__(self, parameters: TrackerParameters, table: ResponseTable | None = None) -> None:
        self._table = table if table is not None else load_table(parameters.response_table)
        self._spacing = parameters.sample_spacing
        self._tempering = parameters.tempering * parameters.sample_spacing / TEMPERED_SPACING
        self._missing = parameters.missing_cost * self._table.absent

    def log_likelihoods(self, states: FloatArray, observation: WorkingImage) -> FloatArray:
        """Return the log-likelihood ratio of each cable, either polarity as likely; shape (N,)."""
        return marginal_log_ratios(self.measure(states, observation).log_ratios, 0.5)

    def measure(self, states: FloatArray, image: WorkingImage) -> CableEvidence:
        """Measure cables, shape (N, 4) or more columns."""
        borders = project_borders(states)
        blocks = [
            self._measure_block(
                Borders(
                    borders.angles[start : start + CABLES_AT_ONCE],
                    borders.offsets[start : start + CABLES_AT_ONCE],
                ),
                image,
            )
            for start in range(0, len(states), CABLES_AT_ONCE)
        ]
        return functools.reduce(CableEvidence.joined, blocks)

    def _measure_block(self, borders: Borders, image: WorkingImage) -> CableEvidence:
        spacing = self._spacing * image.frame_size[0] / REFERENCE_WIDTH
        points, inside = sample_points(borders, spacing, image.frame_size)
        measures = measure_points(borders, points, inside, image)
        sums = np.zeros((2, *inside.shape), np.float32)
        sums[0][inside] = self._table.look_up(measures)
        sums[1][inside] = self._table.look_up(measures.negative())
        counts = inside.sum(axis=2)
        # A border that runs through the picture has as many points as the picture is high. Points
        # beyond the edge cannot be seen, but a cable that has none is not to be believed for free.
        expected = image.frame_size[1] / spacing
        missing = self._missing * np.maximum(expected - counts, 0.0)
        # Bright, dark; cables; left, right.
        totals = sums.sum(axis=3, dtype=np.float64) + missing
        per_point = totals / np.maximum(counts, expected)
        return CableEvidence(
            self._tempering * totals.sum(axis=2).T,
            per_point.min(axis=2).T,
            counts.min(axis=1).astype(np.float64),
        )


def measure_points(
    borders: Borders, points: FloatArray, inside: BoolArray, image: WorkingImage
) -> PointMeasures:
    """Measure the frame on borders.

    Parameters
    ----------
    borders : Borders
        N pairs.
    points, inside : FloatArray, BoolArray
        Their points, shapes (N, 2, M, 2) and (N, 2, M): see `geometry.sample_points`.
    image : WorkingImage
        The frame.

    Returns
    -------
    PointMeasures
        Of the points inside the image, in the order of `inside`.
    """
    # Inward: from the left border to the right, from the right border to the left.
    inward = np.stack((np.cos(borders.angles), np.sin(borders.angles)), axis=-1)
    inward = inward * np.array([1.0, -1.0])[:, None]
    normals = np.broadcast_to(inward[:, :, None, :], (*inside.shape, 2))[inside]
    widths = np.abs(borders.offsets[:, 1] - borders.offsets[:, 0]) * image.reduction
    width = np.broadcast_to(widths[:, None, None], inside.shape)[inside]
    places = image.to_working(points[inside])
    responses, slopes = _edges_at(image, places, normals)
    return PointMeasures(responses, slopes, _contrasts_at(image, places, normals, width))


def _contrasts_at(
    image: WorkingImage, places: FloatArray, normals: FloatArray, widths: FloatArray
) -> Image:
    """Return how much brighter the inside is than the outside; 0 where its parts disagree.

    A furrow has dark borders too, but what lies between them is bottom: the inside is looked at
    close behind the border and in the middle of the cable, and the smaller contrast counts.
    """
    without = _smooth_at(image, places - OUTSIDE * image.scale * normals)
    behind, middle = (
        _smooth_at(image, places + depth[:, None] * normals) - without
        for depth in (
            np.clip(BEHIND * widths, NEAREST * image.scale, FARTHEST_BEHIND * image.scale),
            np.clip(widths / 2, NEAREST * image.scale, FARTHEST_MIDDLE * image.scale),
        )
    )
    smaller = np.sign(behind) * np.minimum(np.abs(behind), np.abs(middle))
    agreed = np.where(behind * middle > 0.0, smaller, 0.0).astype(np.float32)
    contrasts: Image = agreed / np.float32(image.contrast_scale)
    return contrasts


def _edges_at(image: WorkingImage, places: FloatArray, normals: FloatArray) -> tuple[Image, Image]:
    pixels = image_to_pixel(places, image.size)
    values = read_channels(image.gradients.channels, pixels[:, 0], pixels[:, 1])
    x, y = normals.astype(np.float32).T
    responses = values[:, 0] * x + values[:, 1] * y
    slopes = (values[:, 2] * x + values[:, 3] * y) / (np.abs(responses) + SMALLEST_RESPONSE)
    return responses, slopes * np.float32(image.scale)


def _smooth_at(image: WorkingImage, places: FloatArray) -> Image:
    pixels = image_to_pixel(places, image.size)
    return read_channels(image.smooth, pixels[:, 0], pixels[:, 1])[:, 0]


def marginal_log_ratios(log_ratios: FloatArray, bright: float) -> FloatArray:
    """Return the log-likelihood ratios (N,) of cables whose polarity is not known.

    Parameters
    ----------
    log_ratios : FloatArray
        Of bright and of dark cables, shape (N, 2).
    bright : float
        Probability that the cable is brighter than the bottom, above 0 and below 1.
    """
    result: FloatArray = np.logaddexp(
        np.log(bright) + log_ratios[:, 0], np.log1p(-bright) + log_ratios[:, 1]
    )
    return result


def bright_shares(log_ratios: FloatArray, bright: float) -> FloatArray:
    """Return the posterior probability that each cable is a bright one, shape (N,)."""
    log_odds = np.log(bright) - np.log1p(-bright) + log_ratios[:, 0] - log_ratios[:, 1]
    shares: FloatArray = 1.0 / (1.0 + np.exp(np.clip(-log_odds, -700.0, 700.0)))
    return shares
