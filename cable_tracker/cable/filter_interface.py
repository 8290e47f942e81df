"""What the tracker asks of a filter and of a whole-image detector.

Of a filter: a belief after each frame, and what that belief says. The detectors themselves are in
`detection`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.movement import MotionAid
from cable_tracker.cable.model.state import POSE_SIZE
from cable_tracker.particle_filter.particles import Particles


class ParticleBelief(Protocol):
    """What any filter believes: particles at least. Never changed in place."""

    @property
    def particles(self) -> Particles:
        """The particles."""
        ...


BeliefType = TypeVar("BeliefType", bound=ParticleBelief)


@dataclass(frozen=True, slots=True, eq=False)
class BeliefSummary:
    """What a belief says about the cable in a frame.

    Attributes
    ----------
    covariance : FloatArray
        Covariance of the error of the estimate, shape (8, 8), columns of `StateColumn`.
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
        Whether the estimate is of what an operator or planner gave, if something was given; True if
        the filter cannot tell.
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
    follows_given: bool = True
    presence: float | None = None
    event: str = ""


class CableFilter(ABC, Generic[BeliefType]):
    """A filter over the cable, for frames of one size. It holds no belief itself."""

    search_time: float = float("inf")
    """Without a claim for this long, the tracker starts the search anew [s]; infinite for a filter
    that does so by itself."""

    @abstractmethod
    def first_belief(self) -> BeliefType:
        """Return the belief of a search: the prior, without a history."""

    @abstractmethod
    def given_belief(self, states: FloatArray) -> BeliefType:
        """Return the belief after states (N, 8) of the cable were given."""

    def guessed_belief(self, states: FloatArray) -> BeliefType:
        """Return the belief after states (N, 8) were given that may be of something else.

        A filter that cannot tell the two apart believes either.
        """
        return self.given_belief(states)

    @abstractmethod
    def converted(self, belief: ParticleBelief) -> BeliefType:
        """Return the belief of any filter as this one's, with as many particles as wanted."""

    def is_searching(self, belief: BeliefType) -> bool:
        """Tell whether it is more likely than not that no cable is followed.

        A filter that does not know it follows one.
        """
        return False

    def is_known(self, belief: BeliefType) -> bool:
        """Tell whether it is known where the cable is: then a detector has nothing to propose."""
        return False

    @abstractmethod
    def step(
        self,
        belief: BeliefType,
        image: WorkingImage,
        dt: float,
        detections: FloatArray,
        motion: MotionAid | None = None,
    ) -> BeliefType:
        """Return the belief after one more frame.

        Parameters
        ----------
        belief : BeliefType
            After the frame before.
        image : WorkingImage
            The frame.
        dt : float
            Time between the two [s]; 0 for a belief about this very frame.
        detections : FloatArray
            d, alpha, w, beta of cables that a detector sees in it [px, rad], shape (K, 4).
        motion : MotionAid or None
            How odometry says that the cable has moved; None: by its own rates. None if `dt` is 0.
        """

    @abstractmethod
    def summary(self, belief: BeliefType, image: WorkingImage) -> BeliefSummary:
        """Return what a belief says about the frame that it came from."""


class CableProposer(Protocol):
    """Proposes cables in a frame, without a memory."""

    def propose(self, image: WorkingImage, *, is_searching: bool) -> FloatArray:
        """Return d, alpha, w, beta of cables in the frame [px, rad], best first, shape (K, 4).

        Parameters
        ----------
        image : WorkingImage
            The frame.
        is_searching : bool
            Whether it is more likely than not that the tracker follows none: a proposal may take
            more time then.
        """
        ...


NO_PROPOSALS = np.empty((0, POSE_SIZE))
"""No cables."""


class NoProposer:
    """Proposes nothing."""

    def propose(self, image: WorkingImage, *, is_searching: bool) -> FloatArray:
        """Return no cables, shape (0, 4)."""
        return NO_PROPOSALS
