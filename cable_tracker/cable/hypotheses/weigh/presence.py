"""The log-odds that a hypothesis is a cable, and not something of the bottom.

The log-likelihood ratios of frames (`score_likelihood`) add up while a hypothesis goes on, only a
part of each frame's, for what looks like a cable in one frame does so in the next.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.weigh.score_likelihood import (
    FrameScores,
    ScoreModel,
    frame_log_likelihood_ratio,
)
from cable_tracker.cable.parameters.parameters import HIGHEST_PRESENCE_LOG_ODDS
from cable_tracker.compilation import compiled_loop
from cable_tracker.particle_filter.existence import log_odds_of, probability_of

NEW_LOG_ODDS = log_odds_of(0.02)
"""Log-odds of a new hypothesis, before its first frame."""

LIKELY_PRESENCE = 0.5
"""From this probability on it is more likely than not that there is a cable."""

LEAST_PRESENCE = 1e-3
"""Probability of a cable before any frame has been seen, and the least after one."""

LOWEST, HIGHEST = math.log(LEAST_PRESENCE / (1.0 - LEAST_PRESENCE)), HIGHEST_PRESENCE_LOG_ODDS
"""Limits of the log-odds of a hypothesis [nats], so that later frames can turn them."""


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
