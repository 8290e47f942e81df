"""What the target tracker asks of a filter: after each frame a summary and a belief."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.target.measure.outline import Outline
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.parameters.parameters import TargetParameters


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
        Whether its size means something.
    presence : float
        Probability that the target is in view.
    effective_sample_size, score : float
        N_eff and score, see `TargetEstimate`.
    supports_claim, supports_keeping : bool
        Whether the frame speaks for claiming the target, and for going on to claim it.
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
    """What any filter believes of a target: particles at least. Never changed in place."""

    @property
    def particles(self) -> Particles:
        """The particles, in pixels of the working image."""
        ...


BeliefType = TypeVar("BeliefType", bound=TargetBelief)


class TargetFilter(ABC, Generic[BeliefType]):
    """A filter over the outline of one target. It holds no belief itself.

    Parameters
    ----------
    parameters : TargetParameters
        Parameters of the filter.
    rng : numpy.random.Generator
        The only source of randomness.
    """

    def __init__(self, parameters: TargetParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._rng = rng

    @abstractmethod
    def start(
        self, frame: WorkingFrame, mask: BoolArray, *, is_exact: bool
    ) -> tuple[TargetSummary, BeliefType]:
        """Learn a target from its pixels in a frame; say what it shows, and what is believed then.

        Raises
        ------
        FrameError
            The mask is too small, or does not stand out from its surroundings.
        """

    @abstractmethod
    def step(
        self,
        belief: BeliefType,
        frame: WorkingFrame,
        dt: float,
        motion: CameraMotion | None,
        others: FloatArray,
        *,
        counts_for: float,
    ) -> tuple[TargetSummary, BeliefType]:
        """Follow the target into the next frame; say what it shows, and what is believed then.

        Parameters
        ----------
        belief : BeliefType
            After the frame before.
        frame : WorkingFrame
            The frame.
        dt : float
            Time since the frame before, in which the target may have moved [s].
        motion : CameraMotion or None
            Motion of the camera since then.
        others : FloatArray
            Poses of the other targets that are claimed, shape (K, 6): they exclude this one.
        counts_for : float
            Time that the frame counts for where something is learnt from it [s]: `dt`, but after a
            pause that of one frame.
        """
