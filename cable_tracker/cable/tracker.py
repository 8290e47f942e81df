"""The cable tracker: a frame and its time in, an estimate out."""

from __future__ import annotations

import copy
import math

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.engine import Finding, TrackingEngine
from cable_tracker.cable.hypotheses.multi_hypothesis_engine import MultiHypothesisEngine
from cable_tracker.cable.hypotheses.proposer import CableProposer, NoProposer
from cable_tracker.cable.measure.response_table import ResponseTable, load_table
from cable_tracker.cable.measure.working_image import WorkingImage, check_frame, make_working_image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initialisation import StatePrior, states_from_prior
from cable_tracker.cable.model.motion_aid import MotionAid
from cable_tracker.cable.model.state import CableState, StateColumn
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH, TrackerParameters
from cable_tracker.cable.thesis.bootstrap_engine import BootstrapEngine
from cable_tracker.compilation import uses_compiled_kernels
from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.tracking.status import StatusMachine
from cable_tracker.tracking.succession import FrameMark, succession


class CableTracker:
    """Track one cable through a sequence of frames.

    Parameters
    ----------
    parameters : TrackerParameters
        The same parameters, frames and times give the same estimates, bit for bit.
    proposer : CableProposer or None
        Finds cables in whole images for the filter `multi_hypothesis`; None: nothing does.
        `cable_tracker.trackers.make_tracker` chooses the one that the parameters name.

    Raises
    ------
    ParameterError
        The response table cannot be read.

    Examples
    --------
    >>> import numpy as np
    >>> tracker = CableTracker(TrackerParameters(seed=1))
    >>> estimate = tracker.process(np.zeros((240, 320), np.uint8), stamp=1_000_000_000)
    >>> estimate.status.value
    'INITIALISING'
    """

    def __init__(
        self,
        parameters: TrackerParameters | None = None,
        proposer: CableProposer | None = None,
    ) -> None:
        self._parameters = parameters if parameters is not None else TrackerParameters()
        self._proposer = proposer if proposer is not None else NoProposer()
        self._rng = np.random.default_rng(self._parameters.seed)
        self._table = load_table(self._parameters.response_table)
        self._engine = self._make_engine(self._parameters, self._table)
        self._prior: StatePrior | None = None
        self._status = StatusMachine()
        self._frame: FrameMark | None = None

    @property
    def parameters(self) -> TrackerParameters:
        """The parameters in force."""
        return self._parameters

    @property
    def particles(self) -> Particles | None:
        """The present belief; None before the first frame."""
        return self._engine.particles

    def configure(
        self, parameters: TrackerParameters, proposer: CableProposer | None = None
    ) -> None:
        """Take other parameters from now on, and keep the belief.

        A changed number of particles draws that many from the present ones. A changed seed waits
        for the next reset. Another filter starts with the particles of the one before. The response
        table is read when another file is named, and never again.

        Parameters
        ----------
        parameters : TrackerParameters
            All of them.
        proposer : CableProposer or None
            Another one; None keeps the present one.

        Raises
        ------
        ParameterError
            The response table cannot be read. Nothing has changed.
        """
        table = self._table
        if parameters.response_table != self._parameters.response_table:
            table = load_table(parameters.response_table)
        engine = self._make_engine(parameters, table)
        if self._frame is not None:
            engine.take_over(self._engine, self._frame.size)
        self._engine = engine
        self._parameters = parameters
        self._table = table
        if proposer is not None:
            self._proposer = proposer
            engine.use(proposer)

    def reset(self) -> None:
        """Forget everything; the next frame is like the first, with the same random numbers."""
        self._rng = np.random.default_rng(self._parameters.seed)
        self._engine = self._make_engine(self._parameters, self._table)
        self._prior = None
        self._status = StatusMachine()
        self._frame = None

    def copy(self) -> CableTracker:
        """Return another tracker that goes on as this one would, bit for bit, and apart from it."""
        # What never changes is shared: the response table is many times as large as the rest.
        shared = {id(part): part for part in (self._table, self._parameters)}
        return copy.deepcopy(self, shared)

    def initialise(self, prior: StatePrior) -> None:
        """Start the next frame from a given belief instead of the present one.

        The cable is claimed with that frame already if its borders are there.

        Raises
        ------
        FrameError
            The state is not finite, or a sigma is negative.
        """
        if not prior.state.is_finite() or bool(np.any(prior.sigma < 0.0)):
            raise FrameError("the initial state must be finite, and its sigmas not negative")
        self._prior = prior

    def process(self, image: Image, stamp: int, motion: MotionAid | None = None) -> CableEstimate:
        """Take one frame into account.

        Parameters
        ----------
        image : Image
            Grey levels, uint8 or float32 (0..255), shape (H, W).
        stamp : int
            Time of the frame [ns].
        motion : MotionAid or None
            How odometry says that a cable has moved since the frame before.

        Raises
        ------
        FrameError
            The frame cannot be used, or has the same time as the frame before. Nothing has changed.
        """
        check_frame(image)
        frame = FrameMark((image.shape[1], image.shape[0]), stamp)
        has_moved = self._frame is not None
        step = succession(self._frame, frame, self._parameters.maximum_gap)
        if step.event:
            self._engine.forget()
            self._status = StatusMachine()
        self._frame = frame
        working_image = make_working_image(
            image,
            self._parameters.working_width,
            self._parameters.filter_sigma,
            self._parameters.sample_spacing,
            compiled=uses_compiled_kernels(self._parameters.kernels),
        )
        known = motion if has_moved and not step.event else None
        finding = self._find(working_image, step.dt, known)
        return self._estimate(finding, step.dt, step.event)

    def _find(self, image: WorkingImage, dt: float, motion: MotionAid | None) -> Finding:
        prior, self._prior = self._prior, None
        if prior is not None:
            states = states_from_prior(prior, self._parameters, image.frame_size[0], self._rng)
            self._status = StatusMachine().expecting()
            return self._engine.start(states, image, self._status)
        return self._engine.advance(image, dt, self._status, motion)

    def _make_engine(self, parameters: TrackerParameters, table: ResponseTable) -> TrackingEngine:
        if parameters.filter == "bootstrap":
            return BootstrapEngine(parameters, table, self._rng)
        return MultiHypothesisEngine(parameters, table, self._proposer, self._rng)

    def _estimate(self, finding: Finding, dt: float, event: str) -> CableEstimate:
        assert self._frame is not None
        converged = self._has_converged(finding.covariance, self._frame.size[0])
        self._status = finding.status.after(
            rises=converged and finding.rises,
            holds=converged and finding.holds,
            dt=dt,
            parameters=self._parameters,
        )
        return CableEstimate(
            stamp=self._frame.stamp,
            status=self._status.status,
            state=CableState.from_array(finding.mean),
            covariance=finding.covariance,
            effective_sample_size=finding.effective_sample_size,
            evidence=finding.evidence,
            image_size=self._frame.size,
            event=event,
            presence=finding.presence,
            hypotheses=finding.hypotheses,
        )

    def _has_converged(self, covariance: FloatArray, image_width: int) -> bool:
        scale = image_width / REFERENCE_WIDTH
        sigma_distance = math.sqrt(covariance[StateColumn.DISTANCE, StateColumn.DISTANCE])
        sigma_angle = math.sqrt(covariance[StateColumn.ANGLE, StateColumn.ANGLE])
        return (
            sigma_distance <= self._parameters.converged_distance * scale
            and sigma_angle <= math.radians(self._parameters.converged_angle)
        )
