"""How sure it is that a hypothesis is a cable, and not something of the bottom.

How well strips fit a frame that are drawn at random is the frame's own null: on coarse gravel any
strip fits well somewhere. A hypothesis is judged by how far it stands above that, in its spreads.
Even without a cable the best of all strips stands high; what is compared is the density of its
score with a cable and without. The log-odds of each hypothesis add up while it goes on, only a part
of each frame's, for what looks like a cable in one frame does so in the next.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.border_points import FrameScan
from cable_tracker.cable.measure.likelihood_ratio import (
    CableEvidence,
    RatioModel,
    marginal_log_ratio,
    measure_into,
)
from cable_tracker.cable.model.geometry import borders_cross_inside, unwrap_state
from cable_tracker.cable.model.state import STATE_SIZE
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH
from cable_tracker.compilation import compiled, compiled_inside

NULL_STRIPS = 64
"""Strips that are drawn at random in each frame."""

FEWEST_STRIPS = 8
"""A frame in which fewer of them are possible says nothing of the null."""

NULL_TIME = 0.4
"""Time over which the null is averaged [s]."""

SMALLEST_SPREAD = 0.5
"""Smallest spread of the null [nats]."""

BORDER_DISTANCE, BORDER_TURN = 10.0, 0.12
"""A strip with a border as near as this to one of the leader's shares it [px at 320 px, rad]."""

EMPTY_MODE, EMPTY_SCALE = 4.3, 1.33
"""Of the Gumbel law of the best hypothesis' score on frames without a cable."""

CABLE_MEAN, CABLE_SPREAD = 13.0, 4.5
"""Of the Gaussian of the score of a visible cable."""

HIGHEST_SCORE = 16.0
"""Higher scores say no more than this one."""

HIDDEN_SHARE = 0.5
"""Share of the frames in which nothing is learnt of a cable: growth, sand, shadows."""

LARGEST_ODDS = 6.0
"""A frame says no more than this for a hypothesis [nats]."""

NEW_ODDS = math.log(0.02 / 0.98)
"""Log-odds of a new hypothesis, before its first frame."""

LOWEST, HIGHEST = math.log(1e-3 / (1.0 - 1e-3)), 5.0
"""Log-odds stay between these, so that they can turn again in time."""

NEAR = np.array([14.0, 0.2, 14.0, 0.2])
"""How far a hypothesis may be from where one of the frame before is expected, to be that one: d,
alpha, w, beta [px at the reference width, rad]."""

THINNEST_FACTOR = 0.5


class NullLevels(NamedTuple):
    """Log-likelihood ratios of random strips, averaged over the last frames.

    Attributes
    ----------
    mean, square : float
        Means of the ratios and of their squares.
    known : bool
        Whether any frame has been looked at.
    """

    mean: float = 0.0
    square: float = 0.0
    known: bool = False

    @property
    def spread(self) -> float:
        """Their standard deviation."""
        return max(math.sqrt(max(self.square - self.mean**2, 0.0)), SMALLEST_SPREAD)

    def updated(self, mean: float, square: float, dt: float) -> NullLevels:
        """Return the levels after a frame with these means, `dt` seconds later."""
        share = -math.expm1(-dt / NULL_TIME) if self.known else 1.0
        return NullLevels(
            self.mean + share * (mean - self.mean),
            self.square + share * (square - self.square),
            True,
        )


def frame_odds(score: float) -> float:
    """Return the log-likelihood ratio of a score, cable against none [nats]."""
    # Below its mode the law falls so steeply that it would speak for a cable.
    score = min(max(score, EMPTY_MODE), HIGHEST_SCORE)
    place = (score - EMPTY_MODE) / EMPTY_SCALE
    empty = -place - math.exp(min(-place, 50.0)) - math.log(EMPTY_SCALE)
    deviation = (score - CABLE_MEAN) / CABLE_SPREAD
    cable = -0.5 * deviation**2 - math.log(CABLE_SPREAD * math.sqrt(2 * math.pi))
    seen = (1.0 - HIDDEN_SHARE) * math.exp(min(cable - empty, 50.0))
    return min(math.log(seen + HIDDEN_SHARE), LARGEST_ODDS)


@compiled_inside
def thin_factor(width: float, thin_width: float) -> float:
    """Return what the evidence for a strip of some width counts: any bottom has thin lines."""
    return min(max(math.sqrt(max(width, 0.0) / thin_width), THINNEST_FACTOR), 1.0)


@compiled
def null_moments(
    strips: FloatArray,
    scan: FrameScan,
    model: RatioModel,
    p_bright: float,
    leader: FloatArray,
    image_size: tuple[float, float],
) -> tuple[int, float, float]:
    """Return number, mean ratio and mean square of random strips that are none of the leader's.

    Parameters
    ----------
    strips : FloatArray
        Shape (N, 8).
    scan, model : FrameScan, RatioModel
        Of the frame.
    p_bright : float
        Probability that a cable is bright.
    leader : FloatArray
        The leading hypothesis, shape (8,).
    image_size : (float, float)
        Width and height of the frame [px].
    """
    count = len(strips)
    evidence = CableEvidence(np.empty((count, 2)), np.empty((count, 2)), np.empty(count))
    measure_into(strips, 0, len(strips), scan, model, evidence)
    log_bright, log_dark = math.log(p_bright), math.log1p(-p_bright)
    scale = image_size[0] / REFERENCE_WIDTH
    chart = np.empty(STATE_SIZE)
    used, total, squares = 0, 0.0, 0.0
    for row in range(len(strips)):
        unwrap_state(strips[row], leader[1], chart)
        shared = borders_cross_inside(chart, image_size)
        for side in (-1.0, 1.0):
            for other in (-1.0, 1.0):
                apart = chart[0] + 0.5 * side * chart[2] - leader[0] - 0.5 * other * leader[2]
                turn = chart[1] + side * chart[3] - leader[1] - other * leader[3]
                shared = shared or (
                    abs(apart) < BORDER_DISTANCE * scale and abs(turn) < BORDER_TURN
                )
        if shared:
            continue
        ratio = marginal_log_ratio(
            log_bright + evidence.log_ratios[row, 0], log_dark + evidence.log_ratios[row, 1]
        )
        used, total, squares = used + 1, total + ratio, squares + ratio * ratio
    return used, total / max(used, 1), squares / max(used, 1)


@compiled
def inherited_odds(
    expected: FloatArray, log_odds: FloatArray, means: FloatArray, image_width: float
) -> FloatArray:
    """Return the log-odds (K,) that hypotheses inherit; NaN for new ones.

    Parameters
    ----------
    expected, log_odds : FloatArray
        Where those of the frame before are expected, shape (J, 8), and their log-odds, shape (J,).
    means : FloatArray
        The hypotheses, shape (K, 8).
    image_width : float
        Width of the frame [px].
    """
    scale = image_width / REFERENCE_WIDTH
    chart, inherited = np.empty(STATE_SIZE), np.full(len(means), np.nan)
    for index in range(len(means)):
        nearest = 1.0
        for other in range(len(expected)):
            unwrap_state(means[index], expected[other, 1], chart)
            distance = 0.0
            for column in range(4):
                unit = scale if column % 2 == 0 else 1.0
                apart = abs(chart[column] - expected[other, column])
                distance = max(distance, apart / (NEAR[column] * unit))
            if distance < nearest:
                nearest, inherited[index] = distance, log_odds[other]
    return inherited


def updated_odds(
    inherited: float, score: float, survival: float, appearance: float, gain: float
) -> float:
    """Return the log-odds of a hypothesis after a frame.

    Parameters
    ----------
    inherited : float
        Before it; NaN for a new hypothesis.
    score : float
        How far it stands above the null [spreads].
    survival, appearance : float
        Probability that a cable that was there still is, and that one has come.
    gain : float
        Share of the frame's evidence that counts for a hypothesis that goes on.
    """
    odds = frame_odds(score)
    if math.isnan(inherited):
        return min(max(NEW_ODDS + odds, LOWEST), HIGHEST)
    before = probability_of(inherited)
    predicted = min(max(before * survival + (1.0 - before) * appearance, 1e-9), 1.0 - 1e-9)
    after = log_odds_of(predicted) + gain * odds
    return min(max(after, LOWEST), HIGHEST)


def log_odds_of(probability: float) -> float:
    """Return the log-odds of a probability above 0 and below 1."""
    return math.log(probability) - math.log1p(-probability)


def probability_of(log_odds: float) -> float:
    """Return the probability that has these log-odds."""
    return 1.0 / (1.0 + math.exp(-log_odds))
