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
from cable_tracker.cable.model.geometry import unwrap_states
from cable_tracker.cable.model.state import POSE_SIZE, StateColumn, pose_units
from cable_tracker.cable.parameters.parameters import REFERENCE_RATE
from cable_tracker.compilation import compiled_inside
from cable_tracker.particle_filter.existence import log_odds_of, probability_of


class ScoreModel(NamedTuple):
    """How hypotheses stand out of frames, with a cable and without.

    Attributes
    ----------
    empty_mode, empty_scale : float
        Of the Gumbel law of the best hypothesis' standard score on frames without a cable.
    cable_mean, cable_deviation : float
        Of the Gaussian of the standard score of a visible cable.
    highest_score : float
        Higher standard scores say no more than this one.
    ordinary_margin, ordinary_slope : float
        A lower margin is that of ripples and grain [nats], and says so much against a cable per
        nat.
    clear_margin, clear_slope : float
        Margins above this are found on cables alone [nats], and say so much more per nat.
    clearness, clearness_slope : float
        Borders that are clearer than this are found on cables alone [nats per point in view], and
        say so much more per nat.
    least_shown, enough_shown : float
        So clear are short edges, too: with less length in view, as a share of the picture's height,
        it says nothing of a cable, with more than the other all.
    hidden_share : float
        Share of the frames in which nothing is learnt of a cable: growth, sand, shadows.
    largest_log_odds : float
        A frame says no more than this for a hypothesis [nats].
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

    @property
    def least_log_odds(self) -> float:
        """A frame does not say more than this against a cable, which may be hidden in it [nats]."""
        return math.log(self.hidden_share) - 0.2


MODEL = ScoreModel()

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
    margin : float
        How far its log-likelihood ratio is above that of strips like it [nats].
    standard_score : float
        How far it is above the mean of strips of any kind [their standard deviations].
    clearness, shown : float
        See `BorderClearness`.
    """

    margin: float
    standard_score: float
    clearness: float
    shown: float


def frame_log_odds(standing: Standing) -> float:
    """Return what a frame says for a cable against none [nats]."""
    margin = standing.margin
    odds = _log_ratio_of_score(standing.standard_score)
    odds += MODEL.clear_slope * max(margin - MODEL.clear_margin, 0.0)
    if margin < MODEL.ordinary_margin:
        odds = min(odds, MODEL.ordinary_slope * (margin - MODEL.ordinary_margin))
    # A short strip, in a corner, never stands as high as one through the whole picture.
    clearer = max(standing.clearness - MODEL.clearness, 0.0)
    odds += MODEL.clearness_slope * _enough(standing.shown) * clearer
    return min(max(odds, MODEL.least_log_odds), MODEL.largest_log_odds)


def _enough(shown: float) -> float:
    share = (shown - MODEL.least_shown) / (MODEL.enough_shown - MODEL.least_shown)
    return min(max(share, 0.0), 1.0)


def _log_ratio_of_score(score: float) -> float:
    # Below its mode the law falls so steeply that it would speak for a cable.
    score = min(max(score, MODEL.empty_mode), MODEL.highest_score)
    place = (score - MODEL.empty_mode) / MODEL.empty_scale
    empty = -place - math.exp(min(-place, 50.0)) - math.log(MODEL.empty_scale)
    deviation = (score - MODEL.cable_mean) / MODEL.cable_deviation
    cable = -0.5 * deviation**2 - math.log(MODEL.cable_deviation * math.sqrt(2 * math.pi))
    visible = (1.0 - MODEL.hidden_share) * math.exp(min(cable - empty, 50.0))
    return math.log(visible + MODEL.hidden_share)


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
    distances = _distances(expected, means, image_width)
    inherited = log_odds[distances.argmin(axis=0)]
    return np.where(distances.min(axis=0) < 1.0, inherited, np.nan)


def leader_goes_on(expected: FloatArray, means: FloatArray, image_width: float) -> bool:
    """Tell whether the first of the hypotheses (K, 8) is the first of those that are expected."""
    return bool(_distances(expected[:1], means[:1], image_width)[0, 0] < 1.0)


def _distances(expected: FloatArray, means: FloatArray, image_width: float) -> FloatArray:
    """Return how far apart hypotheses are, shape (J, K), in units of `NEAR`."""
    near = NEAR * pose_units(image_width)
    before, now = len(expected), len(means)
    angles = np.repeat(expected[:, StateColumn.ANGLE], now)
    chart = unwrap_states(np.tile(means, (before, 1)), angles)[:, :POSE_SIZE]
    apart = np.abs(chart.reshape(before, now, POSE_SIZE) - expected[:, None, :POSE_SIZE])
    distances: FloatArray = (apart / near).max(axis=2)
    return distances


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


def gain_over(gain: float, dt: float) -> float:
    """Return the share of a frame's evidence that is new, for its share at 25 frames per second.

    What looks like a cable in one frame does so in the next, the less the longer that is after.
    """
    frames = dt * REFERENCE_RATE if dt > 0.0 else 1.0
    return 1.0 - math.pow(1.0 - gain, frames)
