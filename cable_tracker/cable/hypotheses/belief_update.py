"""The belief after a frame: what its conclusion changes in the belief before."""

from __future__ import annotations

from cable_tracker.cable.hypotheses.belief import Belief
from cable_tracker.cable.hypotheses.conclusion import Conclusion
from cable_tracker.cable.hypotheses.first_claim import is_new_clear, leading_evidence
from cable_tracker.cable.hypotheses.predict.remembered_cable import remember
from cable_tracker.cable.hypotheses.weigh.presence import LIKELY_PRESENCE
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.existence import probability_of
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.tracking.rates import over_time

MEMORY_PRESENCE, MEMORY_MASS = 0.9, 0.7
"""Minimum presence and minimum mass of the leading cluster for updating the memory."""

POLARITY_DOUBT = 0.02
"""The probability that the cable is bright stays this far from 0 and 1."""


def updated_belief(
    before: Belief,
    conclusion: Conclusion,
    dt: float,
    parameters: TrackerParameters,
    image_size: tuple[int, int],
    scale: float,
) -> Belief:
    """Return the belief after a frame.

    Parameters
    ----------
    before : Belief
        Belief before the frame, aged to its time.
    conclusion : Conclusion
        Particles, clusters and log-odds after the frame, at least one cluster.
    dt : float
        Time since the frame before [s].
    parameters : TrackerParameters
        The tracker's parameters.
    image_size : (int, int)
        Width and height of the frames [px].
    scale : float
        Pixels of the frames per pixel of an image of the reference width.
    """
    hypotheses = conclusion.hypotheses
    presence = probability_of(float(conclusion.log_odds[0]))
    is_known = conclusion.goes_on and before.is_known(parameters.known_after)
    is_clear = is_new_clear(hypotheses, before.memory, parameters, scale)
    evidence = leading_evidence(hypotheses, parameters)
    # Of what could not be claimed nothing is learnt: neither place nor width nor polarity.
    is_learnt_from = is_known or is_clear
    believed = presence if is_learnt_from else 0.0
    memory = before.memory
    if believed >= MEMORY_PRESENCE and hypotheses.clusters.masses[0] >= MEMORY_MASS:
        leader = hypotheses.clusters.means[0]
        memory = remember(memory, leader, image_size, dt, parameters, scale)
    p_bright = updated_p_bright(
        before.p_bright, conclusion.p_bright, believed, parameters.polarity_memory, dt
    )
    # Too faint to claim, or, if it is known, to keep.
    is_faint = evidence < parameters.evidence_to_lose if is_known else not is_clear
    is_too_faint = is_faint and presence >= parameters.presence_to_track
    goes_on = conclusion.goes_on and presence >= LIKELY_PRESENCE
    return Belief(
        particles=Particles(conclusion.states, conclusion.log_weights),
        hypotheses=hypotheses,
        presence=presence,
        p_bright=p_bright,
        memory=memory,
        log_odds=conclusion.log_odds,
        faint_time=before.faint_time + dt if is_too_faint else 0.0,
        evidence=evidence,
        is_clear=is_clear,
        known_time=before.known_time + (dt if is_learnt_from else 0.0) if goes_on else 0.0,
        is_given=before.is_given and goes_on,
    )


def updated_p_bright(
    before: float, found: float, presence: float, memory: float, dt: float
) -> float:
    """Return the probability that the cable is bright, after a frame.

    Parameters
    ----------
    before : float
        That probability before the frame.
    found : float
        Share of the particles' weight that speaks for a bright cable.
    presence : float
        Probability that there is a cable: without one the frame says nothing.
    memory : float
        Factor per frame at 25 frames per second on the deviation from 0.5, 0 to 1.
    dt : float
        Time since the frame before [s].
    """
    kept = over_time(memory, dt)
    now = presence * found + (1.0 - presence) * before
    p_bright = kept * now + (1.0 - kept) * 0.5
    return float(min(max(p_bright, POLARITY_DOUBT), 1.0 - POLARITY_DOUBT))
