"""The particles of one frame while they are drawn, from several proposals, and weighed together."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.prior_density import MINIMUM_DENSITY, PriorDensities
from cable_tracker.cable.measure.likelihood_ratio import CableEvidence
from cable_tracker.cable.model.state import PLACES
from cable_tracker.particle_filter.kernel_mixture import KernelMixture
from cable_tracker.particle_filter.student_t import StudentT

Proposal: TypeAlias = StudentT | KernelMixture


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """Particles with what is known of them, in the chart of the prior.

    Attributes
    ----------
    states : FloatArray
        Shape (N, 8).
    densities : PriorDensities
        At them.
    log_ratios : FloatArray
        Log-likelihood ratio of the frame, and of the width, shape (N,).
    width_factors : FloatArray
        The part of the width: 0 for the usual one, negative for others, shape (N,).
    evidence : CableEvidence
        What it was made of.
    """

    states: FloatArray
    densities: PriorDensities
    log_ratios: FloatArray
    width_factors: FloatArray
    evidence: CableEvidence

    def joined(self, other: Drawn) -> Drawn:
        """Return these particles and then others."""
        return Drawn(
            np.concatenate((self.states, other.states)),
            self.densities.joined(other.densities),
            np.concatenate((self.log_ratios, other.log_ratios)),
            np.concatenate((self.width_factors, other.width_factors)),
            self.evidence.joined(other.evidence),
        )


@dataclass(frozen=True, slots=True, eq=False)
class MixtureSample:
    """Particles and the mixture that they were drawn from.

    Attributes
    ----------
    drawn : Drawn
        The particles.
    survivors, births : int
        How many were drawn from the two parts of the prior.
    proposals : tuple of (int, Proposal)
        How many were drawn from what else.
    """

    drawn: Drawn
    survivors: int
    births: int
    proposals: tuple[tuple[int, Proposal], ...]

    def extended(self, drawn: Drawn, proposals: tuple[tuple[int, Proposal], ...]) -> MixtureSample:
        """Return the sample with more particles, drawn from more proposals."""
        return MixtureSample(
            self.drawn.joined(drawn), self.survivors, self.births, self.proposals + proposals
        )

    def log_weights(self, power: float) -> FloatArray:
        """Return log(f L^power / q) of each particle, shape (N,).

        q is the density of the whole mixture times the number of particles, so that for power 1 the
        weights sum to the likelihood ratio "a cable against none" times the mass of f.
        """
        # Zero times -inf, the ratio of what is impossible, is no number.
        ratios = power * self.drawn.log_ratios if power > 0.0 else 0.0
        return ratios + self.drawn.densities.full - self._log_mixture()

    def _log_mixture(self) -> FloatArray:
        places = self.drawn.states[:, :PLACES]
        parts = [
            math.log(self.survivors or MINIMUM_DENSITY) + self.drawn.densities.survivors,
            math.log(self.births or MINIMUM_DENSITY) + self.drawn.densities.births,
            *(
                math.log(count) + log_density(proposal, places)
                for count, proposal in self.proposals
                if count
            ),
        ]
        total: FloatArray = np.logaddexp.reduce(parts)
        return total


def log_density(proposal: Proposal, points: FloatArray) -> FloatArray:
    """Return the log-density of a proposal at points (N, 4), shape (N,)."""
    if isinstance(proposal, StudentT):
        return proposal.log_density(points)
    count = len(proposal.centres)
    density: FloatArray = proposal.log_densities(points, (np.full(count, 1.0 / count),))[0]
    return density
