"""Probability that a target is in view: by the scores of its region, and by its contour."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.particle_filter.existence import PredictedExistence, update_existence
from cable_tracker.particle_filter.particles import log_sum_exp
from cable_tracker.particle_filter.student_t import log_peak_density
from cable_tracker.target.model.state import X, Y, distances_from
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.frame_sampler import DrawnParticles, FrameSampler, ScoredPoses
from cable_tracker.target.poses.known_target import ContourHistograms, UsualScore
from cable_tracker.target.poses.pose_belief import PoseBelief

LEAST_PRESENCE, MOST_PRESENCE = 1e-3, 1.0 - 1e-3
"""Limits of the probability of presence, so that it can change again in time."""

CLEAR_OF_TARGET = 1.5
"""Random places this far from the target count as clutter, in roots of its area."""

CLUTTER_TAIL = 3.0
"""Degrees of freedom of the Student-t about the usual score of clutter."""

LEAST_SPREAD = 0.2
"""Lower bound of the spread of scores; also the spread of pictures without any texture."""

STUDENT_PEAK = math.exp(log_peak_density(CLUTTER_TAIL, 1))
"""Density of that Student-t at its middle, for a unit spread."""


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
        student = (
            STUDENT_PEAK
            * (1.0 + standard**2 / CLUTTER_TAIL) ** (-(CLUTTER_TAIL + 1) / 2)
            / self.spread
        )
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


def presence_by_scores(
    sampler: FrameSampler, drawn: DrawnParticles, rng: np.random.Generator
) -> float:
    """Return the probability of presence after the particles of a frame have been scored.

    Parameters
    ----------
    rng : numpy.random.Generator
        Draws places for clutter.
    """
    parameters, measured, known = sampler.parameters, sampler.measured, sampler.belief.known
    poses = drawn.poses
    clutter = clutter_of(
        measured.scores(_random_places(sampler, poses, rng), known.template),
        parameters.clutter_share if measured.frame.is_coloured else parameters.grey_clutter_share,
    )
    ratios = clutter.log_ratios(poses.scores, known.usual, parameters.score_spread)
    ratios = np.clip(ratios, -parameters.evidence_limit, parameters.evidence_limit)
    evidence = log_sum_exp(poses.log_prior - drawn.log_proposal + ratios)
    evidence -= math.log(len(poses.scores))
    existence = sampler.prediction.existence
    return update_existence(existence, evidence, LEAST_PRESENCE, MOST_PRESENCE)


def _random_places(
    sampler: FrameSampler, poses: ScoredPoses, rng: np.random.Generator
) -> FloatArray:
    """Return poses (K, 6) anywhere but at the best particle, of its scale and angle."""
    best = poses.states[int(np.argmax(poses.scores))]
    height, width = sampler.measured.frame.shape
    count = sampler.parameters.clutter_places
    states = np.tile(best, (count, 1))
    states[:, :2] = (rng.random((count, 2)) - 0.5) * [width, height]
    apart = distances_from(best[X], best[Y], states)
    clear: FloatArray = states[apart > CLEAR_OF_TARGET * sampler.belief.size]
    return clear


def presence_by_likeness(
    belief: PoseBelief,
    shown: ContourHistograms | None,
    parameters: TargetParameters,
    *,
    is_coloured: bool,
) -> float:
    """Return the probability of presence after the likeness of the contour."""
    if shown is None:
        return belief.presence
    least = parameters.likeness_spread if is_coloured else parameters.grey_likeness_spread
    ratio = log_ratio_of_likeness(shown.likeness, belief.known.usual_likeness, least)
    ratio = min(max(ratio, -parameters.likeness_limit), parameters.likeness_limit)
    before = PredictedExistence(belief.presence, 0.0)
    return update_existence(
        before, ratio + math.log(belief.presence), LEAST_PRESENCE, MOST_PRESENCE
    )


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
