"""What a belief says about the cable in a frame: the estimate, and whether it supports a claim."""

from __future__ import annotations

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.filter_interface import BeliefSummary
from cable_tracker.cable.hypotheses.association import is_same_hypothesis
from cable_tracker.cable.hypotheses.belief import Belief
from cable_tracker.cable.hypotheses.border_displacement import (
    displaced_covariance,
    width_before_smoothing,
)
from cable_tracker.cable.hypotheses.clearness import leading_evidence
from cable_tracker.cable.hypotheses.clusters import Clusters
from cable_tracker.cable.hypotheses.conclusion import Hypotheses
from cable_tracker.cable.measure.border_points import MINIMUM_LENGTH
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.geometry import wrap_state
from cable_tracker.cable.model.state import CableState, StateColumn
from cable_tracker.cable.model.statistics import wrapped_estimate
from cable_tracker.cable.parameters.parameters import TrackerParameters

FAMILIAR = 2.0
"""Largest difference from the remembered cable, in scales of its place and spreads of its width."""

SMALLEST_HYPOTHESIS = 0.01
"""Minimum mass of a cluster that is reported; the leading one always is."""


def belief_summary(
    belief: Belief, parameters: TrackerParameters, image_width: int
) -> BeliefSummary:
    """Return what a belief says about the frame that it came from, `image_width` pixels wide."""
    hypotheses = belief.hypotheses
    mean, covariance = leading_estimate(hypotheses, parameters, image_width)
    evidence = leading_evidence(hypotheses, parameters)
    visible = hypotheses.visible_length >= MINIMUM_LENGTH
    is_acceptable = visible and (belief.is_clear or is_familiar(belief, parameters, image_width))
    is_claimable = (
        is_acceptable
        and belief.presence >= parameters.presence_to_track
        and evidence >= parameters.evidence_to_track
    )
    return BeliefSummary(
        mean=mean,
        covariance=covariance,
        effective_sample_size=hypotheses.effective_size,
        evidence=evidence,
        supports_claim=is_claimable,
        supports_new_claim=is_claimable and belief.is_clear,
        supports_keeping=is_acceptable
        and belief.presence >= parameters.presence_to_lose
        and evidence >= parameters.evidence_to_lose,
        presence=belief.presence,
        hypotheses=_reported(hypotheses.clusters, parameters, image_width),
    )


def is_familiar(belief: Belief, parameters: TrackerParameters, image_width: int) -> bool:
    """Tell whether the leader may be the cable that was tracked.

    It is the one of the frames before, or lies where that may be by now, and is about as wide.
    """
    if belief.known_time > 0.0:
        return True
    memory = belief.memory
    if memory is None:
        return False
    leader = belief.hypotheses.clusters.means[0]
    width = float(leader[StateColumn.WIDTH])
    if abs(memory.width_deviation(width, parameters)) > FAMILIAR:
        return False
    return is_same_hypothesis(leader, memory.pose, FAMILIAR * memory.scales(image_width))


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
    return wrapped_estimate(_unsmoothed(leader, parameters, image_width), displaced)


def _unsmoothed(mean: FloatArray, parameters: TrackerParameters, image_width: int) -> FloatArray:
    """Return a cluster's mean (8,) with the width that the cable has, not its smoothed borders."""
    state = mean.copy()
    width = float(state[StateColumn.WIDTH])
    state[StateColumn.WIDTH] = width_before_smoothing(width, parameters, image_width)
    return state


def _reported(
    clusters: Clusters, parameters: TrackerParameters, image_width: int
) -> tuple[Hypothesis, ...]:
    """Return the clusters that are worth mention, and the first whatever its mass."""
    reported = []
    for index, mass in enumerate(clusters.masses.tolist()):
        if index == 0 or mass >= SMALLEST_HYPOTHESIS:
            state = _unsmoothed(clusters.means[index], parameters, image_width)
            reported.append(Hypothesis(mass, CableState.from_array(wrap_state(state))))
    return tuple(reported)
