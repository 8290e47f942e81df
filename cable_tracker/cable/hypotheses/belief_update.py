"""The belief after a frame: what its conclusion changes in the belief before."""

from __future__ import annotations

from cable_tracker.cable.hypotheses.belief import Belief
from cable_tracker.cable.hypotheses.clearness import is_new_clear, leading_evidence
from cable_tracker.cable.hypotheses.conclusion import Conclusion, Hypotheses
from cable_tracker.cable.hypotheses.polarity import updated_p_bright
from cable_tracker.cable.hypotheses.presence import LIKELY_PRESENCE
from cable_tracker.cable.hypotheses.remembered_cable import remember
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.existence import probability_of
from cable_tracker.particle_filter.particles import Particles

MEMORY_PRESENCE, MEMORY_MASS = 0.9, 0.7
"""Minimum presence and minimum mass of the leading cluster for updating the memory."""


class BeliefUpdate:
    """Puts the belief after a frame together, for frames of one size.

    Parameters
    ----------
    parameters : TrackerParameters
        The tracker's parameters.
    image_size : (int, int)
        Width and height of the frames [px].
    """

    def __init__(self, parameters: TrackerParameters, image_size: tuple[int, int]) -> None:
        self._parameters = parameters
        self._image_size = image_size

    def updated_belief(self, before: Belief, conclusion: Conclusion, dt: float) -> Belief:
        """Return the belief after a frame.

        Parameters
        ----------
        before : Belief
            Belief before the frame, aged to its time.
        conclusion : Conclusion
            Particles, clusters and log-odds after the frame, at least one cluster.
        dt : float
            Time since the frame before [s].
        """
        hypotheses = conclusion.hypotheses
        presence = probability_of(float(conclusion.log_odds[0]))
        leader = hypotheses.clusters.means[0]
        is_known = conclusion.goes_on and before.is_known(self._parameters.known_after)
        is_clear = is_new_clear(hypotheses, before.memory, self._parameters, self._image_size[0])
        # Of what could not be claimed nothing is learnt: neither place nor width nor polarity.
        is_learnt_from = is_known or is_clear
        believed = presence if is_learnt_from else 0.0
        is_remembered = believed >= MEMORY_PRESENCE and hypotheses.clusters.masses[0] >= MEMORY_MASS
        return Belief(
            particles=Particles(conclusion.states, conclusion.log_weights),
            hypotheses=hypotheses,
            presence=presence,
            p_bright=updated_p_bright(
                before.p_bright, conclusion.p_bright, believed, self._parameters.polarity_memory, dt
            ),
            memory=(
                remember(before.memory, leader, self._image_size, dt, self._parameters)
                if is_remembered
                else before.memory
            ),
            log_odds=conclusion.log_odds,
            refused_time=(
                before.refused_time + dt
                if self._is_refused(hypotheses, presence, is_known=is_known, is_clear=is_clear)
                else 0.0
            ),
            is_clear=is_clear,
            known_time=(
                before.known_time + (dt if is_learnt_from else 0.0)
                if conclusion.goes_on and presence >= LIKELY_PRESENCE
                else 0.0
            ),
        )

    def _is_refused(
        self, hypotheses: Hypotheses, presence: float, *, is_known: bool, is_clear: bool
    ) -> bool:
        """Tell whether a cable is present that is too faint to claim, or, if known, to keep."""
        parameters = self._parameters
        if is_known:
            is_faint = leading_evidence(hypotheses, parameters) < parameters.evidence_to_lose
        else:
            is_faint = not is_clear
        return presence >= parameters.presence_to_track and is_faint
