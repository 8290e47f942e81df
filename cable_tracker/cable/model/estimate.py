"""What the tracker says about one frame."""

from __future__ import annotations

from dataclasses import dataclass

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import CableState
from cable_tracker.particle_filter.particles import standard_deviations
from cable_tracker.tracking.status import TrackingStatus


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One of the places where the cable may be.

    Attributes
    ----------
    probability : float
        Its share of the particles' weights, 0 to 1. Hypotheses are in the order of this times the
        probability that they are cables, so that the first need not have the largest share.
    state : CableState
        Mean of its particles [px, rad, per second].
    """

    probability: float
    state: CableState


@dataclass(frozen=True, slots=True, eq=False)
class CableEstimate:
    """The posterior over the cable after one frame.

    Attributes
    ----------
    stamp : int
        Time of the frame [ns].
    status : TrackingStatus
        Whether a cable is claimed.
    state : CableState
        Weighted mean of the particles (MMSE) of the leading hypothesis [px, rad, per second]. Meant
        for the controller only while the status is TRACKING.
    covariance : FloatArray
        Covariance of its error, shape (8, 8), columns of `CableState`.
    effective_sample_size : float
        N_eff, between 1 and N, before resampling.
    evidence : float
        How clearly the image shows the weaker border of the estimate. With the observation
        `likelihood_ratio`: mean log-likelihood ratio of its points, border against bottom; a
        map (parameter `looks`) on which the strip is clear raises it to at most `evidence_to_find`.
        With `responses`: mean response of its points over the frame's robust scale; zero when the
        borders disagree.
    image_size : (int, int)
        Width and height of the frame [px].
    event : str
        Why the tracker started anew with this frame; empty on ordinary frames.
    presence : float or None
        Probability that a cable is in view, 0 to 1; None where the filter has no notion of it.
    hypotheses : tuple of Hypothesis
        Hypotheses of the cable, the one most likely to be a cable first: that of `state`.
    """

    stamp: int
    status: TrackingStatus
    state: CableState
    covariance: FloatArray
    effective_sample_size: float
    evidence: float
    image_size: tuple[int, int]
    event: str = ""
    presence: float | None = None
    hypotheses: tuple[Hypothesis, ...] = ()

    @property
    def is_claimed(self) -> bool:
        """Whether a cable is claimed."""
        return self.status is TrackingStatus.TRACKING

    @property
    def claimed_state(self) -> CableState | None:
        """State that is claimed to a controller; None while none is."""
        return self.state if self.is_claimed else None

    def standard_deviations(self) -> FloatArray:
        """Return the square roots of the covariance's diagonal, shape (8,)."""
        return standard_deviations(self.covariance)
