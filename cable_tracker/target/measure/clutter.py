"""Likelihoods of a score: of the target, and of places without it in the same frame."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.particle_filter.student_t import log_peak_density

TAIL = 3.0
"""Degrees of freedom of the Student-t about the usual score of clutter."""

LEAST_SPREAD = 0.2
"""Lower bound of the spread of scores; also the spread of pictures without any texture."""

STUDENT_PEAK = math.exp(log_peak_density(TAIL, 1))
"""Density of that Student-t at its middle, for a unit spread."""


@dataclass(frozen=True, slots=True)
class UsualScore:
    """The scores of the target while it was in view.

    Attributes
    ----------
    mean, variance : float
        Exponential moving mean and variance of the score.
    """

    mean: float
    variance: float

    def updated(self, score: float, rate: float) -> UsualScore:
        """Return the statistics after one more score; `rate` is its weight."""
        gap = score - self.mean
        variance = (1.0 - rate) * (self.variance + rate * gap * gap)
        return replace(self, mean=self.mean + rate * gap, variance=variance)


def log_ratio_of_likeness(likeness: float, usual: UsualScore, least: float) -> float:
    """Return log p(likeness | target) / p(likeness | clutter), clutter having any from 0 to 1.

    Parameters
    ----------
    likeness : float
        Likeness of the histogram in the contour to that of the target, 0 to 1.
    usual : UsualScore
        Mean and variance of the target's own likeness.
    least : float
        Lower bound of the spread of that likeness.
    """
    spread = max(math.sqrt(usual.variance), least)
    below = min(likeness - usual.mean, 0.0) / spread
    return -0.5 * below * below - math.log(spread * math.sqrt(2.0 * math.pi))


@dataclass(frozen=True, slots=True)
class Clutter:
    """The scores of places of one frame where the target is not.

    Attributes
    ----------
    middle, spread : float
        Median and half the 16-84 % range of the scores.
    uniform_share : float
        Weight of a uniform density in that of clutter.
    """

    middle: float
    spread: float
    uniform_share: float

    def log_ratios(self, scores: FloatArray, usual: UsualScore, least: float) -> FloatArray:
        """Return log p(score | target) / p(score | clutter), shape (N,).

        Parameters
        ----------
        scores : FloatArray
            Shape (N,).
        usual : UsualScore
            Scores of the target. A score above the usual is as good as the usual one.
        least : float
            Least spread of the usual score, as a share of it.
        """
        spread = max(math.sqrt(usual.variance), least * abs(usual.mean), LEAST_SPREAD)
        below = np.minimum(scores - usual.mean, 0.0) / spread
        target = -0.5 * below**2 - math.log(spread * math.sqrt(2.0 * math.pi))
        standard = (scores - self.middle) / self.spread
        student = STUDENT_PEAK * (1.0 + standard**2 / TAIL) ** (-(TAIL + 1) / 2) / self.spread
        even = 1.0 / max(2.0 * abs(usual.mean), 1.0)
        clutter = (1.0 - self.uniform_share) * student + self.uniform_share * even
        ratios: FloatArray = target - np.log(clutter)
        return ratios


def clutter_of(scores: FloatArray, uniform_share: float) -> Clutter:
    """Return the statistics of clutter from random places of a frame.

    Parameters
    ----------
    scores : FloatArray
        Scores of places where the target is not, shape (K,).
    uniform_share : float
        See `Clutter`.
    """
    if len(scores) == 0:
        return Clutter(0.0, LEAST_SPREAD, uniform_share)
    # The same as np.percentile, without its overhead.
    places = np.array([0.16, 0.5, 0.84]) * (len(scores) - 1)
    low, middle, high = np.interp(places, np.arange(len(scores)), np.sort(scores))
    return Clutter(float(middle), max(float(high - low) / 2.0, LEAST_SPREAD), uniform_share)
