"""A node that stands in for the tracker with one of the baselines inside, for comparison only.

It is a node of its own, and no parameter of the tracker node: a vehicle should not be set up with a
method that the project knows to be worse, and a user of the tracker should not have to read about
it in the tracker's table of parameters. Everything around the method is the tracker node's own
code, so that a comparison in the closed loop shows what the methods are worth and nothing else:
name and topics, how frames wait for their instruments, metres with their covariance, diagnostics.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.model.movement import MotionAid
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.evaluation.methods import BASELINES, METHODS, Method
from cable_tracker.ros import node_parameters
from cable_tracker.ros.nodes.tracker_node import TrackerNode
from cable_tracker.trackers import CableTracker
from cable_tracker.tracking.parameter_table import ParameterSet, word


@dataclass(frozen=True, slots=True, kw_only=True)
class BaselineParameters(ParameterSet):
    """Of the node that stands in for the tracker, beside the tracker's; read at start only."""

    method: str = word(BASELINES[0], BASELINES, "Baseline to track with.")


class MethodTracker:
    """A method of the evaluation, with what a node calls of a `CableTracker`.

    Parameters
    ----------
    make : callable
        Makes a fresh method from a seed.
    parameters : TrackerParameters
        Parameters of the node; a baseline uses the seed only.
    """

    def __init__(self, make: Callable[[int], Method], parameters: TrackerParameters) -> None:
        self._make = make
        self._parameters = parameters
        self._method = make(parameters.seed)

    @property
    def parameters(self) -> TrackerParameters:
        """The parameters of the node."""
        return self._parameters

    @property
    def particles(self) -> None:
        """There are none."""
        return

    def configure(self, parameters: TrackerParameters) -> None:
        """Use other parameters; a changed seed takes effect with the next reset."""
        self._parameters = parameters

    def reset(self) -> None:
        """Forget everything."""
        self._method = self._make(self._parameters.seed)

    def initialise(self, given: GivenState) -> None:
        """Start the next frame from the middle of a given belief."""
        self._method.initialise(given)

    def process(self, image: Image, stamp: int, motion: MotionAid | None = None) -> CableEstimate:
        """Take one frame (H, W) into account; `motion` is not used: baselines take no odometry.

        Raises
        ------
        FrameError
            The frame cannot be used.
        """
        return self._method.process(image, stamp)


class BaselineNode(TrackerNode):
    """The tracker node with a baseline inside; the parameter `method` names it.

    The parameters of the filter are there and have no effect.
    """

    def _make_tracker(self, parameters: TrackerParameters) -> CableTracker:
        own = node_parameters.declare_set(self, BaselineParameters(), read_only=True)
        return cast("CableTracker", MethodTracker(METHODS[own.method].make, parameters))
