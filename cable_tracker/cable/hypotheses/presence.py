"""How sure it is that a hypothesis is a cable, and not something of the bottom.

On coarse gravel any strip fits well somewhere, on ripples any that runs along them. A hypothesis is
judged by its score and its level: how far its log-likelihood ratio is above that of strips of any
kind, and of strips like it, see `background`. Even without a cable the best of all strips stands
high; what is compared is the density of its score with a cable and without. The log-odds of each
hypothesis add up while it goes on, only a part of each frame's, for what looks like a cable in one
frame does so in the next.

The constants were chosen on the simulated worlds to tune on (`tune_*`) and on frames of real sea
bed without a cable.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import unwrap_states
from cable_tracker.cable.model.state import POSE_SIZE, StateColumn
from cable_tracker.cable.parameters.parameters import REFERENCE_RATE, REFERENCE_WIDTH
from cable_tracker.compilation import compiled_inside

EMPTY_MODE, EMPTY_SCALE = 4.3, 1.33
"""Of the Gumbel law of the best hypothesis' score on frames without a cable [spreads]."""

CABLE_MEAN, CABLE_SPREAD = 13.0, 4.5
"""Of the Gaussian of the score of a visible cable [spreads]."""

HIGHEST_SCORE = 16.0
"""Higher scores say no more than this one [spreads]."""

ORDINARY_LEVEL, ORDINARY_SLOPE = 8.0, 0.15
"""A lower level is that of ripples and grain [nats], and says so much against a cable per nat."""

CLEAR_LEVEL, CLEAR_SLOPE = 18.0, 0.35
"""Levels above this are found on cables alone [nats], and say so much more per nat."""

CLEARNESS, CLEARNESS_SLOPE = 1.1, 16.0
"""Borders that are clearer than this are found on cables alone [nats per point in view], and say so
much more per nat."""

LEAST_SHOWN, ENOUGH_SHOWN = 0.3, 0.5
"""So clear are short edges, too: with less length in view, as a share of the picture's height, it
says nothing of a cable, with more than the other all."""

HIDDEN_SHARE = 0.5
"""Share of the frames in which nothing is learnt of a cable: growth, sand, shadows."""

LEAST_LOG_ODDS = math.log(HIDDEN_SHARE) - 0.2
"""Nor does it say more than this against one: the cable may be hidden in it [nats]."""

LARGEST_LOG_ODDS = 6.0
"""A frame says no more than this for a hypothesis [nats]."""

NEW_LOG_ODDS = math.log(0.02 / 0.98)
"""Log-odds of a new hypothesis, before its first frame."""

LOWEST, HIGHEST = math.log(1e-3 / (1.0 - 1e-3)), 5.0
"""Log-odds stay between these, so that they can turn again in time."""

NEAR = np.array([14.0, 0.2, 14.0, 0.2])
"""How far a hypothesis may be from where one of the frame before is expected, to be that one: d,
alpha, w, beta [px at the reference width, rad]."""

THINNEST_FACTOR = 0.5
"""The evidence for the thinnest strip counts so much."""


class Standing(NamedTuple):
    """How a hypothesis stands out of a frame.

    Attributes
    ----------
    level : float
        How far its log-likelihood ratio is above that of strips like it [nats].
    score : float
        How far it is above that of strips of any kind [spreads].
    clearness, shown : float
        See `BorderClearness`.
    """

    level: float
    score: float
    clearness: float
    shown: float


def frame_log_odds(standing: Standing) -> float:
    """Return what a frame says for a cable against none [nats]."""
    level = standing.level
    odds = _log_ratio_of_score(standing.score) + CLEAR_SLOPE * max(level - CLEAR_LEVEL, 0.0)
    if level < ORDINARY_LEVEL:
        odds = min(odds, ORDINARY_SLOPE * (level - ORDINARY_LEVEL))
    # A short strip, in a corner, never stands as high as one through the whole picture.
    odds += CLEARNESS_SLOPE * _enough(standing.shown) * max(standing.clearness - CLEARNESS, 0.0)
    return min(max(odds, LEAST_LOG_ODDS), LARGEST_LOG_ODDS)


def _enough(shown: float) -> float:
    return min(max((shown - LEAST_SHOWN) / (ENOUGH_SHOWN - LEAST_SHOWN), 0.0), 1.0)


def _log_ratio_of_score(score: float) -> float:
    # Below its mode the law falls so steeply that it would speak for a cable.
    score = min(max(score, EMPTY_MODE), HIGHEST_SCORE)
    place = (score - EMPTY_MODE) / EMPTY_SCALE
    empty = -place - math.exp(min(-place, 50.0)) - math.log(EMPTY_SCALE)
    deviation = (score - CABLE_MEAN) / CABLE_SPREAD
    cable = -0.5 * deviation**2 - math.log(CABLE_SPREAD * math.sqrt(2 * math.pi))
    return math.log((1.0 - HIDDEN_SHARE) * math.exp(min(cable - empty, 50.0)) + HIDDEN_SHARE)


@compiled_inside
def thin_factor(width: float, thin_width: float) -> float:
    """Return what the evidence for a strip of some width counts: any bottom has thin lines."""
    return min(max(math.sqrt(max(width, 0.0) / thin_width), THINNEST_FACTOR), 1.0)


def inherited_log_odds(
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
    near = NEAR * np.array([scale, 1.0, scale, 1.0])
    before, now = len(expected), len(means)
    angles = np.repeat(expected[:, StateColumn.ANGLE], now)
    chart = unwrap_states(np.tile(means, (before, 1)), angles)[:, :POSE_SIZE]
    apart = np.abs(chart.reshape(before, now, POSE_SIZE) - expected[:, None, :POSE_SIZE])
    distances = (apart / near).max(axis=2)
    inherited = log_odds[distances.argmin(axis=0)]
    return np.where(distances.min(axis=0) < 1.0, inherited, np.nan)


def updated_log_odds(
    inherited: float, standing: Standing, survival: float, appearance: float, gain: float
) -> float:
    """Return the log-odds of a hypothesis after a frame.

    Parameters
    ----------
    inherited : float
        Before it; NaN for a new hypothesis.
    standing : Standing
        How it stands out of the frame.
    survival, appearance : float
        Probability that a cable that was there still is, and that one has come.
    gain : float
        Share of the frame's evidence that counts for a hypothesis that goes on.
    """
    odds = frame_log_odds(standing)
    if math.isnan(inherited):
        return min(max(NEW_LOG_ODDS + odds, LOWEST), HIGHEST)
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


def gain_over(gain: float, dt: float) -> float:
    """Return the share of a frame's evidence that is new, for its share at 25 frames per second.

    What looks like a cable in one frame does so in the next, the less the longer that is after.
    """
    frames = dt * REFERENCE_RATE if dt > 0.0 else 1.0
    return 1.0 - math.pow(1.0 - gain, frames)
