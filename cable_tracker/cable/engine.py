"""What the tracker asks of a filter: where the cable is in each frame, and whether to claim it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.proposer import CableProposer
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.motion_aid import MotionAid
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.tracking.status import StatusMachine


@dataclass(frozen=True, slots=True, eq=False)
class Finding:
    """What a filter found in a frame.

    Attributes
    ----------
    mean : FloatArray
        The estimate, shape (8,), columns of `StateColumn`; its angle in (-pi/2, pi/2].
    covariance : FloatArray
        Of its error, shape (8, 8).
    effective_sample_size : float
        N_eff, before resampling.
    evidence : float
        How clearly the image shows the weaker border.
    rises, holds : bool
        Whether the frame speaks for claiming a cable, and for going on to claim one.
    status : StatusMachine
        The status before this frame.
    presence : float or None
        Probability that a cable is in view, 0 to 1; None if the filter does not know it.
    hypotheses : tuple of Hypothesis
        Likeliest first.
    """

    mean: FloatArray
    covariance: FloatArray
    effective_sample_size: float
    evidence: float
    rises: bool
    holds: bool
    status: StatusMachine
    presence: float | None = None
    hypotheses: tuple[Hypothesis, ...] = ()


class TrackingEngine(Protocol):
    """A filter over the cable with its belief."""

    @property
    def particles(self) -> Particles | None:
        """The present belief; None before the first frame."""
        ...

    def use(self, proposer: CableProposer) -> None:
        """Ask this detector from now on."""
        ...

    def forget(self) -> None:
        """Drop the belief."""
        ...

    def take_over(self, other: TrackingEngine, image_size: tuple[int, int]) -> None:
        """Go on with the belief of another engine, in frames of this size [px]."""
        ...

    def start(self, states: FloatArray, image: WorkingImage, status: StatusMachine) -> Finding:
        """Look at a frame, believing in states (N, 8), equally."""
        ...

    def advance(
        self,
        image: WorkingImage,
        dt: float,
        status: StatusMachine,
        motion: MotionAid | None = None,
    ) -> Finding:
        """Look at the next frame, `dt` seconds later; odometry may say how it has moved."""
        ...
