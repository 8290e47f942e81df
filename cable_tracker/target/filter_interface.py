"""Output of any target filter after each frame: a summary and a belief."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from cable_tracker.arrays import FloatArray
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.target.measure.outline import Outline


@dataclass(frozen=True, slots=True, eq=False)
class TargetSummary:
    """One frame's result, in pixels of the working image.

    Attributes
    ----------
    state, covariance : FloatArray
        Pose, shape (6,), and its covariance, shape (6, 6).
    outline : Outline or None
        Contour; None where the target is beyond the picture.
    is_whole : bool
        Whether the outline shows the whole target, so that its size is meaningful.
    presence : float
        Probability that the target is in view.
    effective_sample_size, score : float
        N_eff and score, see `TargetEstimate`.
    supports_claim, supports_keeping : bool
        Whether the frame supports claiming the target, and keeping the claim.
    """

    state: FloatArray
    covariance: FloatArray
    outline: Outline | None
    is_whole: bool
    presence: float
    effective_sample_size: float
    score: float
    supports_claim: bool
    supports_keeping: bool


class TargetBelief(Protocol):
    """Belief of any filter: particles at least. Immutable."""

    @property
    def particles(self) -> Particles:
        """The particles, in pixels of the working image."""
        ...
