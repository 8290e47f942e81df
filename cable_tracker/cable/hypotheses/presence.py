"""How sure it is that a hypothesis is a cable, and not something of the bottom.

On coarse gravel any strip fits well somewhere, on ripples any that runs along them. A hypothesis is
judged by its standard score and its margin: how far its log-likelihood ratio is above that of
strips of any kind, and of strips like it, see `background`. Even without a cable the best of all
strips stands high; what is compared is the density of its score with a cable and without. The
log-odds of each hypothesis add up while it goes on, only a part of each frame's, for what looks
like a cable in one frame does so in the next.

The constants were chosen on the simulated worlds to tune on (`tune_*`) and on frames of real sea
bed without a cable.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import relative_direction
from cable_tracker.cable.model.state import ANGLE, DISTANCE, SKEW, WIDTH
from cable_tracker.cable.parameters.parameters import REFERENCE_RATE
from cable_tracker.compilation import compiled_inside, compiled_loop
from cable_tracker.particle_filter.existence import log_odds_of, probability_of


class ScoreModel(NamedTuple):
    """How hypotheses stand out of frames, with a cable and without.

    Attributes
    ----------
    empty_mode, empty_scale : float
        Mode and scale of the Gumbel density of the best hypothesis' score on frames without a
        cable.
    cable_mean, cable_deviation : float
        Mean and standard deviation of the Gaussian of the score of a visible cable.
    highest_score : float
        Upper bound of the score.
    ordinary_margin, ordinary_slope : float
        Below `ordinary_margin` [nats] the log-odds are at most `ordinary_slope` (margin -
        `ordinary_margin`): ripples and grain have such margins.
    clear_margin, clear_slope : float
        Above `clear_margin` [nats] `clear_slope` (margin - `clear_margin`) is added to the
        log-odds: only cables have such margins.
    clearness, clearness_slope : float
        Above `clearness` [nats per point in view] `clearness_slope` (c - `clearness`), times
        `shown_share`, is added to the log-odds, c the clearness of the borders.
    least_shown, enough_shown : float
        Length in view, as a share of the picture's height, up to which the clearness does not
        count, and from which it counts fully; linear between. Short edges of the bottom are clear,
        too.
    hidden_share : float
        Probability q that a frame shows nothing of a cable in view: growth, sand, shadows.
    largest_log_odds : float
        Upper bound of the log-odds of one frame [nats].
    """

    empty_mode: float = 4.3
    empty_scale: float = 1.33
    cable_mean: float = 13.0
    cable_deviation: float = 4.5
    highest_score: float = 16.0
    ordinary_margin: float = 8.0
    ordinary_slope: float = 0.15
    clear_margin: float = 18.0
    clear_slope: float = 0.35
    clearness: float = 1.1
    clearness_slope: float = 16.0
    least_shown: float = 0.3
    enough_shown: float = 0.5
    hidden_share: float = 0.5
    largest_log_odds: float = 6.0


MODEL = ScoreModel()

LEAST_LOG_ODDS = math.log(MODEL.hidden_share) - 0.2
"""Lower bound of the log-odds of one frame, in which the cable may be hidden [nats]."""

NEW_LOG_ODDS = math.log(0.02 / 0.98)
"""Log-odds of a new hypothesis, before its first frame."""

LOWEST, HIGHEST = math.log(1e-3 / (1.0 - 1e-3)), 5.0
"""Limits of the log-odds of a hypothesis [nats], so that later frames can turn them."""

NEAR = np.array([14.0, 0.2, 14.0, 0.2])
"""Largest differences of d, alpha, w, beta between a hypothesis and the expected one of the frame
before that it continues [px at the reference width, rad]."""

THINNEST_FACTOR = 0.5
"""Lower bound of `thin_factor`."""


class Standing(NamedTuple):
    """How a hypothesis stands out of a frame.

    Attributes
    ----------
    margin : float
        Log-likelihood ratio above the best strip like it [nats].
    standard_score : float
        Log-likelihood ratio above the mean of strips of any kind, over their standard deviation.
    clearness, shown : float
        Clearness of its borders and length in view, see `BorderClearness`.
    """

    margin: float
    standard_score: float
    clearness: float
    shown: float


class PriorPresence(NamedTuple):
    """What is known of J hypotheses of the frame before, when the next frame comes.

    Attributes
    ----------
    expected : FloatArray
        Where they are expected, the one that leads first, shape (J, 8).
    log_odds : FloatArray
        Log-odds that they were cables, shape (J,) [nats].
    survival, appearance : float
        Probability that a cable in view stays there, and that one appears, before the next frame.
    gain : float
        Share of the frame's evidence that counts for a hypothesis that goes on.
    """

    expected: FloatArray
    log_odds: FloatArray
    survival: float
    appearance: float
    gain: float


@compiled_inside
def frame_log_odds(standing: Standing) -> float:
    """Return what a frame says for a cable against none [nats]."""
    margin = standing.margin
    odds = _log_ratio_of_score(standing.standard_score)
    odds += MODEL.clear_slope * max(margin - MODEL.clear_margin, 0.0)
    if margin < MODEL.ordinary_margin:
        odds = min(odds, MODEL.ordinary_slope * (margin - MODEL.ordinary_margin))
    # A short strip, in a corner, never stands as high as one through the whole picture.
    clearer = max(standing.clearness - MODEL.clearness, 0.0)
    odds += MODEL.clearness_slope * shown_share(standing.shown) * clearer
    return min(max(odds, LEAST_LOG_ODDS), MODEL.largest_log_odds)


@compiled_inside
def shown_share(shown: float) -> float:
    """Return what the clearness of borders counts, 0 to 1; `shown` is that of `BorderClearness`."""
    share = (shown - MODEL.least_shown) / (MODEL.enough_shown - MODEL.least_shown)
    return min(max(share, 0.0), 1.0)


@compiled_inside
def _log_ratio_of_score(score: float) -> float:
    # Below its mode the law falls so steeply that it would speak for a cable.
    score = min(max(score, MODEL.empty_mode), MODEL.highest_score)
    place = (score - MODEL.empty_mode) / MODEL.empty_scale
    empty = -place - math.exp(min(-place, 50.0)) - math.log(MODEL.empty_scale)
    deviation = (score - MODEL.cable_mean) / MODEL.cable_deviation
    cable = -0.5 * deviation * deviation - math.log(MODEL.cable_deviation * math.sqrt(2 * math.pi))
    visible = (1.0 - MODEL.hidden_share) * math.exp(min(cable - empty, 50.0))
    return math.log(visible + MODEL.hidden_share)


@compiled_inside
def thin_factor(width: float, thin_width: float) -> float:
    """Return the factor on the evidence for a strip of a width: sqrt(width / thin_width), 0.5 to 1.

    Any bottom has thin lines.
    """
    return min(max(math.sqrt(max(width, 0.0) / thin_width), THINNEST_FACTOR), 1.0)


@compiled_loop
def inherited_log_odds(prior: PriorPresence, mean: FloatArray, near: FloatArray) -> float:
    """Return the log-odds that a hypothesis inherits; NaN for a new one.

    Parameters
    ----------
    prior : PriorPresence
        The hypotheses of the frame before.
    mean : FloatArray
        The hypothesis, shape (8,).
    near : FloatArray
        `NEAR` for frames of this size, shape (4,) [px, rad].
    """
    inherited, least = math.nan, 1.0
    for index in range(len(prior.log_odds)):
        distance = largest_difference(mean, prior.expected[index], near)
        if distance < least:
            inherited, least = prior.log_odds[index], distance
    return inherited


def goes_on(mean: FloatArray, expected: FloatArray, near: FloatArray) -> bool:
    """Tell whether a hypothesis, shape (8,), is one that is expected; `near` as above."""
    return bool(largest_difference(mean, expected, near) < 1.0)


@compiled_inside
def largest_difference(state: FloatArray, expected: FloatArray, near: FloatArray) -> float:
    """Return the largest difference of d, alpha, w, beta, in the chart about what is expected."""
    wrapped, sign = relative_direction(state[ANGLE], expected[ANGLE])
    beside = max(
        abs(sign * state[DISTANCE] - expected[DISTANCE]) / near[DISTANCE],
        abs(state[WIDTH] - expected[WIDTH]) / near[WIDTH],
    )
    turned = max(abs(wrapped) / near[ANGLE], abs(sign * state[SKEW] - expected[SKEW]) / near[SKEW])
    return float(max(beside, turned))


@compiled_loop
def updated_log_odds(inherited: float, standing: Standing, prior: PriorPresence) -> float:
    """Return the log-odds of a hypothesis after a frame.

    Parameters
    ----------
    inherited : float
        Log-odds before the frame [nats]; NaN for a new hypothesis.
    standing : Standing
        Margin, score and clearness in the frame.
    prior : PriorPresence
        Probabilities of survival and appearance, and gain of the frame.
    """
    odds = frame_log_odds(standing)
    if math.isnan(inherited):
        return min(max(NEW_LOG_ODDS + odds, LOWEST), HIGHEST)
    before = probability_of(inherited)
    predicted = before * prior.survival + (1.0 - before) * prior.appearance
    after = log_odds_of(min(max(predicted, 1e-9), 1.0 - 1e-9)) + prior.gain * odds
    return min(max(after, LOWEST), HIGHEST)


def gain_over(gain: float, dt: float) -> float:
    """Return the share of a frame's log-odds that is new after `dt` seconds.

    `gain` is that share at 25 frames per second. Consecutive frames look alike, the less the longer
    the time between them.
    """
    frames = dt * REFERENCE_RATE if dt > 0.0 else 1.0
    return 1.0 - math.pow(1.0 - gain, frames)
