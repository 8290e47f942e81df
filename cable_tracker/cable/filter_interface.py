"""What the tracker gets of any filter: a belief after each frame, and what that belief says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.particle_filter.particles import Particles


class ParticleBelief(Protocol):
    """What any filter believes: particles at least. Never changed in place."""

    @property
    def particles(self) -> Particles:
        """The particles."""
        ...

    @property
    def is_given(self) -> bool:
        """Whether an operator or planner gave what is followed."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class BeliefSummary:
    """What a belief says about the cable in a frame.

    Attributes
    ----------
    covariance : FloatArray
        Covariance of the error of the estimate, shape (8, 8), columns of `CableState`.
    effective_sample_size : float
        N_eff, before resampling.
    evidence : float
        Mean over the points of the weaker border of what speaks for it, which a map may raise; see
        `CableEstimate.evidence`.
    supports_claim, supports_keeping : bool
        Whether the frame speaks for claiming a cable, and for going on to claim one.
    supports_new_claim : bool
        Whether it speaks for claiming one that nothing was known of.
    hypotheses : tuple of Hypothesis
        By their share times the probability that they are cables, see `Hypothesis`. The first is
        the estimate, its angle in (-pi/2, pi/2].
    contradicts_claim : bool
        Whether the frame speaks against the cable that was tracked last: the estimate is of
        something else, or no cable is in view.
    follows_given : bool
        Whether the estimate is of what an operator or planner gave, not guessed.
    presence : float or None
        Probability that a cable is in view, 0 to 1; None if the filter does not know it.
    event : str
        What there is to say of the frame; mostly nothing.
    """

    covariance: FloatArray
    effective_sample_size: float
    evidence: float
    supports_claim: bool
    supports_keeping: bool
    supports_new_claim: bool
    hypotheses: tuple[Hypothesis, ...]
    contradicts_claim: bool = False
    follows_given: bool = False
    presence: float | None = None
    event: str = ""
