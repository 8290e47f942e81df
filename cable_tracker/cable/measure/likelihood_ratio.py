"""The learnt observation model: how much likelier a frame is with a cable than without.

Where each border crosses the scan lines, the response across it and its slope are looked up in a
table of log-likelihood ratios, border against background. A border that is overgrown at a point
costs a bounded amount there. Neighbouring points are not independent, so the sum is tempered.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray, Image, IndexArray
from cable_tracker.cable.measure.response_table import PointMeasures, ResponseTable, load_table
from cable_tracker.cable.measure.scanned_gradients import Channel, ScanLines
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.geometry import Borders, project_borders
from cable_tracker.cable.parameters.parameters import TrackerParameters

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
        Length inside the image of the shorter border [distances of the scan lines], shape (N,).
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
        self._tempering = parameters.tempering
        self._missing = parameters.missing_cost * self._table.absent

    def log_likelihoods(self, states: FloatArray, observation: WorkingImage) -> FloatArray:
        """Return the log-likelihood ratio of each cable, either polarity as likely; shape (N,)."""
        return marginal_log_ratios(self.measure(states, observation).log_ratios, 0.5)

    def measure(self, states: FloatArray, image: WorkingImage) -> CableEvidence:
        """Measure cables, shape (N, 4) or more columns."""
        blocks = [self._measure_block(block, image) for block in project_borders(states).blocks()]
        return functools.reduce(CableEvidence.joined, blocks)

    def _measure_block(self, borders: Borders, image: WorkingImage) -> CableEvidence:
        points = measure_points(borders, image)
        counts = points.per_border(points.lengths)
        # A border that runs through the picture has as many points as the picture is high. Points
        # beyond the edge cannot be seen, but a cable that has none is not to be believed for free.
        expected = image.size[1] / image.line_spacing
        missing = self._missing * np.maximum(expected - counts, 0.0)
        # Bright, dark; cables; left, right.
        ratios = self._table.look_up(points.measures)
        totals = np.stack(
            [points.per_border(column * points.lengths) + missing for column in ratios.T]
        )
        per_point = totals / np.maximum(counts, expected)
        return CableEvidence(
            self._tempering_in(image) * totals.sum(axis=2).T,
            per_point.min(axis=2).T,
            counts.min(axis=1),
        )

    def _tempering_in(self, image: WorkingImage) -> float:
        return self._tempering * image.line_spacing / image.scale / TEMPERED_SPACING


@dataclass(frozen=True, slots=True, eq=False)
class BorderPoints:
    """Where the borders of N cables cross the scan lines of a frame, inside it: P points.

    Attributes
    ----------
    measures : PointMeasures
        What is there, each of shape (P,).
    borders : IndexArray
        Which border it is of: twice the number of the cable, plus one for the right; shape (P,).
    lengths : FloatArray
        Length of border that the point stands for [distances of the scan lines], shape (P,). At
        least 1; more where the border runs aslant.
    count : int
        N.
    """

    measures: PointMeasures
    borders: IndexArray
    lengths: FloatArray
    count: int

    def per_border(self, values: FloatArray) -> FloatArray:
        """Return the sum of values (P,) along each border, shape (N, 2): left, right."""
        sums: FloatArray = np.bincount(self.borders, values, minlength=2 * self.count).astype(
            np.float64, copy=False
        )
        return sums.reshape(self.count, 2)


def measure_points(borders: Borders, image: WorkingImage) -> BorderPoints:
    """Measure the frame where borders cross its scan lines.

    Steep borders are measured where they cross rows, flat ones where they cross columns.
    """
    cos, sin = np.cos(borders.angles).ravel(), np.sin(borders.angles).ravel()
    offsets = borders.offsets.ravel() * image.reduction
    widths = np.abs(borders.offsets[:, 1] - borders.offsets[:, 0]) * image.reduction
    steep = np.abs(cos) >= np.abs(sin)
    parts = []
    for lines, along, across, chosen in (
        (image.scanned.rows, cos, sin, steep),
        (image.scanned.columns, sin, cos, ~steep),
    ):
        numbers = np.flatnonzero(chosen)
        crossing = _Crossing(along[chosen], across[chosen], offsets[chosen])
        parts.append(_measure_crossings(crossing, numbers, widths, lines, image.scale))
    measures = [part.measures for part in parts]
    return BorderPoints(
        PointMeasures(
            np.concatenate([each.responses for each in measures]),
            np.concatenate([each.slopes for each in measures]),
            np.concatenate([each.contrasts for each in measures]),
        ),
        np.concatenate([part.borders for part in parts]),
        np.concatenate([part.lengths for part in parts]),
        len(borders.angles),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Crossing:
    """Borders that cross scan lines: normal along and across the lines, offset [px]; shape (B,)."""

    along: FloatArray
    across: FloatArray
    offsets: FloatArray


def _measure_crossings(
    crossing: _Crossing, numbers: IndexArray, widths: FloatArray, lines: ScanLines, scale: float
) -> BorderPoints:
    middle = (lines.smooth.shape[1] - 1) / 2
    places = (crossing.offsets[:, None] - crossing.across[:, None] * lines.places) / crossing.along[
        :, None
    ]
    of, line = np.nonzero(np.abs(places) <= middle)
    position = places[of, line] + middle
    # Inward: from the left border to the right, from the right border to the left.
    inward = np.where(numbers % 2 == 0, 1.0, -1.0)[of]
    along, across = crossing.along[of], crossing.across[of]
    values = _read_between(lines.gradients, line, position)
    responses = (
        inward * (along * values[:, Channel.ALONG] + across * values[:, Channel.ACROSS])
    ).astype(np.float32)
    slopes = (scale * values[:, Channel.SLOPE] / along).astype(np.float32)
    # Steps of one pixel inwards are so long along the scan line.
    stretch = inward / along
    without = _read_nearest(lines.smooth, line, position - OUTSIDE * scale * stretch)
    width = widths[numbers[of] // 2]
    behind, middle_of_cable = (
        _read_nearest(lines.smooth, line, position + depth * stretch) - without
        for depth in (
            np.clip(BEHIND * width, NEAREST * scale, FARTHEST_BEHIND * scale),
            np.clip(width / 2, NEAREST * scale, FARTHEST_MIDDLE * scale),
        )
    )
    return BorderPoints(
        PointMeasures(
            responses,
            slopes / (np.abs(responses) + np.float32(SMALLEST_RESPONSE)),
            agreed_contrast(behind, middle_of_cable),
        ),
        numbers[of],
        1.0 / np.abs(along),
        len(widths),
    )


def agreed_contrast(behind: Image, middle: Image) -> Image:
    """Return how much brighter the inside is than the outside; 0 where its parts disagree.

    A furrow has dark borders too, but what lies between them is bottom: the inside is looked at
    close behind the border and in the middle of the cable, and the smaller contrast counts.
    """
    smaller = np.sign(behind) * np.minimum(np.abs(behind), np.abs(middle))
    return np.where(behind * middle > 0.0, smaller, 0.0).astype(np.float32)


def _read_between(gradients: Image, line: IndexArray, position: FloatArray) -> Image:
    """Read gradients at P places inside the lines, linearly along them; shape (P, 3)."""
    left = np.minimum(position.astype(np.int64), gradients.shape[1] - 2)
    share = (position - left).astype(np.float32)[:, None]
    values: Image = gradients[line, left] * (1 - share) + gradients[line, left + 1] * share
    return values


def _read_nearest(values: Image, line: IndexArray, position: FloatArray) -> Image:
    """Read values at P places; beyond the ends of a line its last values go on."""
    nearest = np.clip(position + 0.5, 0, values.shape[1] - 1).astype(np.int64)
    read: Image = values[line, nearest]
    return read


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
