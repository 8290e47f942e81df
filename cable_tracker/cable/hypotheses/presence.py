"""The log-odds that a hypothesis is a cable, and not something of the bottom.

The log-likelihood ratios of frames add up while a hypothesis goes on, only a part of each frame's,
for what looks like a cable in one frame does so in the next. It goes on where the one of the frame
before is expected.

The log-likelihood ratio of a frame follows from the scores of a hypothesis. On coarse gravel any
strip fits well somewhere, on ripples any that runs along them. A hypothesis is judged by its score
and its margin: how far its log-likelihood ratio is above that of strips of any kind [their standard
deviations], and of strips like it [nats], see `background`. Even without a cable the best of all
strips has a high score; what is compared is the density of the score with a cable and without.

A cable that was known before the frame is expected at one place. There the best of many strips is
no measure: without a cable, what lies there is a strip as any other. So a known cable that is
faint stays believed, and one that is gone is given up as soon.

The constants of the scores were chosen on the simulated worlds to tune on (`tune_*`) and on frames
of real sea bed without a cable.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
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

LEAST_SHOWN, ENOUGH_SHOWN = 0.3, 0.5
"""Length in view, as a share of the picture's shorter side, up to which the clearness does not
count, and from which it counts fully; linear between. Short edges of the bottom are clear, too."""

THINNEST_FACTOR = 0.5
"""Lower bound of `thin_factor`."""

LEAST_TRUSTED, MOST_TRUSTED = 4.0 / 3.0, 2.0
"""Widths, in units of `thin_width`, up to which what speaks for a strip in its appearance does not
count, and from which it counts fully; linear between."""


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


class ScoreModel(NamedTuple):
    """Model of the `FrameScores` of hypotheses, with a cable in view and without.

    Attributes
    ----------
    empty_mode, empty_scale : float
        Mode and scale of the Gumbel density of the hypothesis' score on frames without a
        cable.
    cable_mean, cable_deviation : float
        Mean and standard deviation of the Gaussian of the score of a visible cable.
    highest_score : float
        Upper bound of the score.
    ordinary_margin, ordinary_slope : float
        Below `ordinary_margin` [nats] the log-likelihood ratio is at most `ordinary_slope` times
        (margin - `ordinary_margin`): ripples and grain have such margins.
    clear_margin, clear_slope : float
        Above `clear_margin` [nats] `clear_slope` (margin - `clear_margin`) is added to the
        log-likelihood ratio: only cables have such margins.
    ordinary_clearness, clearness_slope : float
        Above it [nats per point in view] `clearness_slope` (c - `ordinary_clearness`), times
        `shown_share`, is added to the log-likelihood ratio, c the clearness of the borders.
    clearness_range : float
        With a clearness so far above it, times `shown_share`, the appearance says nothing
        against a cable: no bottom has such borders.
    appearance_slope, appearance_given : float
        `appearance_slope` (a + `appearance_given`) is added to the log-likelihood ratio that the
        above make, a the appearance of the hypothesis [nats].
    hidden_share : float
        Probability q that a frame shows nothing of a cable in view: growth, sand, shadows.
    largest_log_ratio : float
        Upper bound of the log-likelihood ratio of one frame [nats].
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
    ordinary_clearness: float = 1.1
    clearness_slope: float = 16.0
    clearness_range: float = 0.3
    appearance_slope: float = 1.2
    appearance_given: float = 0.0
    hidden_share: float = 0.5
    largest_log_ratio: float = 6.0


MODEL = ScoreModel()
"""Of the best hypothesis of a frame, wherever it lies."""

KNOWN_MODEL = MODEL._replace(
    empty_mode=1.2,
    empty_scale=1.0,
    ordinary_margin=1.0,
    appearance_given=2.0,
    hidden_share=0.2,
)
"""Of a cable that was known before the frame, where it is expected. Chosen on `tune_*`, on cables
that were given and on places given where none is: there the score is 0.5 to 2 and the margin -4 to
0, of faint cables 4 to 15 and 2 to 20."""

BELOW_HIDDEN = 0.2
"""By how much the log-likelihood ratio may fall below that of a hidden cable [nats]."""


class FrameScores(NamedTuple):
    """How a frame shows a hypothesis.

    Attributes
    ----------
    margin : float
        Log-likelihood ratio above the best strip like it, and above three standard deviations of
        strips of any kind [nats].
    score : float
        Log-likelihood ratio above the mean of strips of any kind, over their standard deviation.
    clearness, shown : float
        Clearness of its borders and length in view, see `BorderClearness`.
    appearance : float
        How much it looks like a cable; without a map see `trusted_appearance` [nats].
    """

    margin: float
    score: float
    clearness: float
    shown: float
    appearance: float


@compiled_inside
def frame_log_likelihood_ratio(scores: FrameScores, model: ScoreModel) -> float:
    """Return the log-likelihood ratio of a frame, a cable against none, limited [nats].

    What the appearance adds is limited with it: what the borders alone say has its own limits.
    """
    margin = scores.margin
    ratio = _log_ratio_of_score(scores.score, model)
    ratio += model.clear_slope * max(margin - model.clear_margin, 0.0)
    if margin < model.ordinary_margin:
        ratio = min(ratio, model.ordinary_slope * (margin - model.ordinary_margin))
    # A short strip, in a corner, never stands as high as one through the whole picture.
    clearer = max(scores.clearness - model.ordinary_clearness, 0.0)
    shown = shown_share(scores.shown)
    ratio += model.clearness_slope * shown * clearer
    ratio = min(max(ratio, least_log_ratio(model)), model.largest_log_ratio)
    appearance = scores.appearance + model.appearance_given
    if appearance < 0.0:
        appearance *= 1.0 - shown * min(clearer / model.clearness_range, 1.0)
    ratio += model.appearance_slope * appearance
    return min(max(ratio, least_log_ratio(model)), model.largest_log_ratio)


@compiled_inside
def least_log_ratio(model: ScoreModel) -> float:
    """Return the lower bound of the log-likelihood ratio of one frame [nats].

    The cable may be hidden in it.
    """
    return math.log(model.hidden_share) - BELOW_HIDDEN


@compiled_inside
def shown_share(shown: float) -> float:
    """Return the factor on the clearness of borders, 0 to 1; `shown` as in `BorderClearness`."""
    share = (shown - LEAST_SHOWN) / (ENOUGH_SHOWN - LEAST_SHOWN)
    return min(max(share, 0.0), 1.0)


@compiled_inside
def _log_ratio_of_score(score: float, model: ScoreModel) -> float:
    """Return ln((1 - q) N(score) / G(score) + q), N that of a cable, G the Gumbel density."""
    # Below its mode the Gumbel density falls steeply, and the ratio would speak for a cable.
    score = min(max(score, model.empty_mode), model.highest_score)
    place = (score - model.empty_mode) / model.empty_scale
    empty = -place - math.exp(-place) - math.log(model.empty_scale)
    deviation = (score - model.cable_mean) / model.cable_deviation
    cable = -0.5 * deviation * deviation - math.log(model.cable_deviation * math.sqrt(2 * math.pi))
    visible = (1.0 - model.hidden_share) * math.exp(cable - empty)
    return math.log(visible + model.hidden_share)


@compiled_inside
def thin_factor(width: float, thin_width: float) -> float:
    """Return the factor on the evidence for a strip of a width: sqrt(width / thin_width), 0.5 to 1.

    Any bottom has thin lines, and few wide ones: what is claimed where there is no cable is thin
    more often than cables are.
    """
    return min(max(math.sqrt(max(width, 0.0) / thin_width), THINNEST_FACTOR), 1.0)


@compiled_inside
def trusted_share(width: float, thin_width: float) -> float:
    """Return how far the appearance of a strip of a width counts, 0 to 1."""
    share = (width / thin_width - LEAST_TRUSTED) / (MOST_TRUSTED - LEAST_TRUSTED)
    return min(max(share, 0.0), 1.0)


@compiled_inside
def trusted_appearance(appearance: float, width: float, thin_width: float) -> float:
    """Return what counts of a strip's appearance [nats]: of a thin one only what speaks against it.

    A rope on the bottom has a cable's looks, and there is no inside of it to be looked at.
    """
    share = trusted_share(width, thin_width)
    return share * appearance + (1.0 - share) * min(appearance, 0.0)
