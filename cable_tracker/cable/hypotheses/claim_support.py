"""What a belief says about the cable in a frame: the estimate, and whether it supports a claim."""

from __future__ import annotations

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.filter_interface import BeliefSummary
from cable_tracker.cable.hypotheses.belief import Belief
from cable_tracker.cable.hypotheses.border_displacement import displaced_covariance
from cable_tracker.cable.hypotheses.clusters import Clusters
from cable_tracker.cable.hypotheses.conclusion import Hypotheses
from cable_tracker.cable.hypotheses.thin_strips import needed_clearness
from cable_tracker.cable.measure.border_points import MINIMUM_POINTS
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.geometry import wrap_state
from cable_tracker.cable.model.state import CableState, StateColumn
from cable_tracker.cable.model.statistics import wrapped_estimate
from cable_tracker.cable.parameters.parameters import TrackerParameters

SMALLEST_HYPOTHESIS = 0.01
"""Minimum mass of a cluster that is reported; the leading one always is."""


def belief_summary(
    belief: Belief, parameters: TrackerParameters, image_width: int
) -> BeliefSummary:
    """Return what a belief says about the frame that it came from, `image_width` pixels wide."""
    hypotheses = belief.hypotheses
    mean, covariance = leading_estimate(hypotheses, parameters, image_width)
    evidence = hypotheses.weaker_border_mean
    visible = hypotheses.visible_length >= MINIMUM_POINTS
    is_claimable = (
        visible
        and belief.presence >= parameters.presence_to_track
        and evidence >= parameters.evidence_to_track
    )
    return BeliefSummary(
        mean=mean,
        covariance=covariance,
        effective_sample_size=hypotheses.effective_size,
        evidence=evidence,
        supports_claim=is_claimable,
        supports_new_claim=is_claimable and is_new_clear(hypotheses, parameters, image_width),
        supports_keeping=visible
        and belief.presence >= parameters.presence_to_lose
        and evidence >= parameters.evidence_to_lose,
        presence=belief.presence,
        hypotheses=_reported(hypotheses.clusters),
    )


def is_new_clear(hypotheses: Hypotheses, parameters: TrackerParameters, image_width: int) -> bool:
    """Tell whether the leader is clear enough to claim it where nothing was known of it."""
    width = float(hypotheses.clusters.means[0, StateColumn.WIDTH])
    return hypotheses.scaled_clearness >= needed_clearness(width, parameters, image_width)


def leading_estimate(
    hypotheses: Hypotheses, parameters: TrackerParameters, image_width: int
) -> tuple[FloatArray, FloatArray]:
    """Return mean (8,) and covariance (8, 8) of the leading cluster, never across clusters."""
    leader = hypotheses.clusters.means[0]
    displaced = displaced_covariance(
        hypotheses.covariance,
        hypotheses.border_means,
        float(leader[StateColumn.WIDTH]),
        parameters,
        image_width,
    )
    return wrapped_estimate(leader, displaced)


def _reported(clusters: Clusters) -> tuple[Hypothesis, ...]:
    """Return the clusters that are worth mention, and the first whatever its mass."""
    masses, means = clusters.masses.tolist(), clusters.means
    return tuple(
        Hypothesis(mass, CableState.from_array(wrap_state(mean)))
        for index, (mass, mean) in enumerate(zip(masses, means, strict=True))
        if index == 0 or mass >= SMALLEST_HYPOTHESIS
    )
