"""The log-odds that a hypothesis is a cable, and not something of the bottom.

The log-likelihood ratios of frames (`score_likelihood`) add up while a hypothesis goes on, only a
part of each frame's, for what looks like a cable in one frame does so in the next. It goes on where
the one of the frame before is expected.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.weigh.score_likelihood import (
    FrameScores,
    ScoreModel,
    frame_log_likelihood_ratio,
)
from cable_tracker.cable.model.geometry import relative_direction
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, WIDTH
from cable_tracker.cable.parameters.parameters import HIGHEST_PRESENCE_LOG_ODDS
from cable_tracker.compilation import compiled_inside, compiled_loop
from cable_tracker.particle_filter.existence import log_odds_of, probability_of

NEW_LOG_ODDS = log_odds_of(0.02)
"""Log-odds of a new hypothesis, before its first frame."""

LIKELY_PRESENCE = 0.5
"""From this probability on it is more likely than not that there is a cable."""

LEAST_PRESENCE = 1e-3
"""Probability of a cable before any frame has been seen, and the least after one."""

LOWEST, HIGHEST = math.log(LEAST_PRESENCE / (1.0 - LEAST_PRESENCE)), HIGHEST_PRESENCE_LOG_ODDS
"""Limits of the log-odds of a hypothesis [nats], so that later frames can turn them."""

SAME_HYPOTHESIS_RADII = np.array([14.0, 0.2, 14.0, 0.2])
"""Largest differences of d, alpha, w, beta between a hypothesis and the expected one of the frame
before that it continues [px at the reference width, rad]."""


class PriorPresence(NamedTuple):
    """Prior of the log-odds in a frame, from J hypotheses of the frame before.

    Attributes
    ----------
    expected : FloatArray
        Their expected states, the leading one first, shape (J, 8).
    log_odds : FloatArray
        Log-odds that they were cables, shape (J,) [nats].
    survival, birth : float
        Probability that a cable in view stays there, and that one appears, before the next frame.
    gain : float
        Share of the frame's log-likelihood ratio that counts for a hypothesis that goes on.
    """

    expected: FloatArray
    log_odds: FloatArray
    survival: float
    birth: float
    gain: float


@compiled_loop
def inherited_log_odds(prior: PriorPresence, mean: FloatArray, radii: FloatArray) -> float:
    """Return the log-odds that a hypothesis inherits; NaN for a new one.

    Parameters
    ----------
    prior : PriorPresence
        The hypotheses of the frame before.
    mean : FloatArray
        The hypothesis, shape (8,).
    radii : FloatArray
        `SAME_HYPOTHESIS_RADII` for frames of this size, shape (4,) [px, rad].
    """
    inherited, least = math.nan, 1.0
    for index in range(len(prior.log_odds)):
        distance = scaled_pose_distance(mean, prior.expected[index], radii)
        if distance < least:
            inherited, least = prior.log_odds[index], distance
    return inherited


@compiled_inside
def is_same_hypothesis(mean: FloatArray, expected: FloatArray, radii: FloatArray) -> bool:
    """Tell whether a hypothesis continues an expected one, shapes (8,), `radii` (4,) [px, rad]."""
    return bool(scaled_pose_distance(mean, expected, radii) < 1.0)


@compiled_inside
def scaled_pose_distance(state: FloatArray, expected: FloatArray, radii: FloatArray) -> float:
    """Return the largest difference of d, alpha, w, beta in units of `radii` (4,) [px, rad].

    The state is taken in the chart about the angle of the expected one, shapes (8,).
    """
    wrapped, sign = relative_direction(state[ANGLE], expected[ANGLE])
    beside = max(
        abs(sign * state[DISTANCE] - expected[DISTANCE]) / radii[DISTANCE],
        abs(state[WIDTH] - expected[WIDTH]) / radii[WIDTH],
    )
    turned = max(
        abs(wrapped) / radii[ANGLE], abs(sign * state[SKEW] - expected[SKEW]) / radii[SKEW]
    )
    return float(max(beside, turned))


@compiled_loop
def updated_log_odds(
    inherited: float, scores: FrameScores, prior: PriorPresence, model: ScoreModel
) -> float:
    """Return the log-odds of a hypothesis after a frame.

    Parameters
    ----------
    inherited : float
        Log-odds before the frame [nats]; NaN for a new hypothesis.
    scores : FrameScores
        How the frame shows it.
    prior : PriorPresence
        Probabilities of survival and birth, and gain of the frame.
    model : ScoreModel
        Of the scores of such a hypothesis.
    """
    ratio = frame_log_likelihood_ratio(scores, model)
    if math.isnan(inherited):
        return min(max(NEW_LOG_ODDS + ratio, LOWEST), HIGHEST)
    before = probability_of(inherited)
    predicted = before * prior.survival + (1.0 - before) * prior.birth
    after = log_odds_of(min(max(predicted, 1e-9), 1.0 - 1e-9)) + prior.gain * ratio
    return min(max(after, LOWEST), HIGHEST)
