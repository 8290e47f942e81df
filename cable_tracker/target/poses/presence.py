"""Probability that a target is in view: by the scores of its region, and by its contour."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.particle_filter.existence import PredictedExistence, update_existence
from cable_tracker.particle_filter.particles import log_sum_exp
from cable_tracker.target.measure.clutter import clutter_of, log_ratio_of_likeness
from cable_tracker.target.model.state import X, Y, distances_from
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.frame_sampler import DrawnParticles, FrameSampler, ScoredPoses
from cable_tracker.target.poses.known_target import ContourHistograms
from cable_tracker.target.poses.pose_belief import PoseBelief

LEAST_PRESENCE, MOST_PRESENCE = 1e-3, 1.0 - 1e-3
"""Limits of the probability of presence, so that it can change again in time."""

CLEAR_OF_TARGET = 1.5
"""Random places this far from the target count as clutter, in roots of its area."""


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
