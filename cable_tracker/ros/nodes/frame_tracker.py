"""Interface of the tracker inside the tracker node."""

from __future__ import annotations

from typing import Protocol

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.movement import MotionAid
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.particles import Particles


class FrameTracker(Protocol):
    """Tracks one cable through the frames of a node, as `CableTracker` does."""

    @property
    def parameters(self) -> TrackerParameters:
        """The parameters in force."""
        ...

    @property
    def particles(self) -> Particles | None:
        """The present belief; None before the first frame, or where there are no particles."""
        ...

    def configure(self, parameters: TrackerParameters) -> None:
        """Take other parameters from now on."""
        ...

    def reset(self) -> None:
        """Forget everything."""
        ...

    def initialise(self, given: GivenState) -> None:
        """Start the next frame from a given state instead of the present belief."""
        ...

    def process(self, image: Image, stamp: int, motion: MotionAid | None = None) -> CableEstimate:
        """Take one frame into account: grey, shape (H, W), and its time [ns]."""
        ...
