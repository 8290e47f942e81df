"""The cable tracker, with its detector: a frame and its time in, an estimate out."""

from __future__ import annotations

import copy
import math
from typing import Any, TypeAlias

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.filter_interface import BeliefSummary, ParticleBelief
from cable_tracker.cable.hypotheses.multi_hypothesis_filter import MultiHypothesisFilter
from cable_tracker.cable.measure.borders.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.borders.response_table import load_table
from cable_tracker.cable.measure.picture.working_image import (
    NO_HISTORY,
    WorkingImage,
    working_image_for,
)
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.initial_state import HUGE, GivenState, draw_given_states
from cable_tracker.cable.model.limits import StateLimits, describe_limit_violations, state_limits
from cable_tracker.cable.model.movement import MotionAid
from cable_tracker.cable.model.state import ANGLE, DISTANCE, POSE_SIZE, WIDTH, CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.thesis.bootstrap_filter import BootstrapFilter, make_observation
from cable_tracker.detection.line_pair_proposer import LinePairProposer
from cable_tracker.detection.line_pairs import pair_limits
from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.tracking.status import StatusMachine, TrackingStatus
from cable_tracker.tracking.succession import FrameMark, check_frame, joined_events, succession

WARM_UP_WIDTH, WARM_UP_HEIGHT = 320, 240
WARM_UP_FRAMES, WARM_UP_TOLD = 6, 5
WARM_UP_STEP = 40_000_000
"""Size of the frames for `warm_up` [px], how many, from which on the tracker has been told where
the cable is, and the time between them [ns]."""

WARM_UP_PARTICLES = 200
"""Number of particles of `warm_up`; compilation does not depend on it."""

NO_PROPOSALS = np.empty((0, POSE_SIZE))
"""No cables."""

Filter: TypeAlias = MultiHypothesisFilter | BootstrapFilter


class CableTracker:
    """Track one cable through a sequence of frames.

    Parameters
    ----------
    parameters : TrackerParameters
        The same parameters, frames and times give the same estimates, bit for bit.

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

    def __init__(self, parameters: TrackerParameters | None = None) -> None:
        self._parameters = parameters if parameters is not None else TrackerParameters()
        self._proposer = make_proposer(self._parameters)
        self._table = load_table(self._parameters.response_table)
        self.reset()

    def reset(self) -> None:
        """Forget everything; the next frame is like the first, with the same random numbers."""
        self._rng = np.random.default_rng(self._parameters.seed)
        self._given: GivenState | None = None
        self._notice = ""
        self._frame: FrameMark | None = None
        self._start_anew()

    def _start_anew(self) -> None:
        """Forget what the frames before have shown."""
        self._filter: Filter | None = None
        self._belief: ParticleBelief | None = None
        self._pictures = NO_HISTORY
        self._status = StatusMachine()

    @property
    def parameters(self) -> TrackerParameters:
        """The parameters in force."""
        return self._parameters

    @property
    def particles(self) -> Particles | None:
        """The present belief; None before the first frame."""
        return self._belief.particles if self._belief is not None else None

    def configure(self, parameters: TrackerParameters) -> None:
        """Take other parameters from now on, and keep the belief.

        A changed number of particles draws that many from the present ones. A changed seed waits
        for the next reset. Another filter starts with the particles of the one before. The response
        table is read when another file is named, and never again.

        Parameters
        ----------
        parameters : TrackerParameters
            All of them.

        Raises
        ------
        ParameterError
            The response table cannot be read. Nothing has changed.
        """
        table = self._table
        if parameters.response_table != self._parameters.response_table:
            table = load_table(parameters.response_table)
        self._parameters = parameters
        self._table = table
        self._proposer = make_proposer(parameters)
        self._filter = None
        if self._frame is not None and self._belief is not None:
            self._filter = self._make_filter(self._frame.size)
            self._belief = self._filter.converted(self._belief)

    def copy(self) -> CableTracker:
        """Return another tracker that goes on as this one would, bit for bit, and apart from it."""
        # What never changes is shared: the response table is many times as large as the rest.
        parts = (self._table, self._table.ratios, self._parameters)
        shared = {id(part): part for part in parts}
        return copy.deepcopy(self, shared)

    def initialise(self, given: GivenState) -> None:
        """Start the next frame from a given state instead of the present belief.

        The cable is claimed with that frame already if its borders are there.

        Raises
        ------
        FrameError
            The state is not finite, a rate is beyond `HUGE`, a sigma is negative, or the width is
            known and not positive.
        """
        if not given.is_acceptable:
            raise FrameError(
                f"the initial state must be finite, its rates within {HUGE:g} per second, and its"
                " sigmas not negative"
            )
        if given.state.width <= 0.0 and not math.isinf(given.sigma[WIDTH]):
            raise FrameError(
                f"a width of {given.state.width:g} px is none; give one above 0, or an infinite"
                " sigma if it is not known"
            )
        self._given = given

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
            The frame cannot be used, its stamp is no time, or it is not later than the frame before
            by a microsecond or more. Nothing has changed.
        """
        check_frame(image)
        frame = FrameMark((image.shape[1], image.shape[0]), stamp)
        has_previous_frame = self._frame is not None
        step = succession(self._frame, frame, self._parameters.maximum_gap)
        if step.event:
            self._start_anew()
        self._frame = frame
        working_image = working_image_for(image, self._parameters, self._pictures, step.dt)
        if step.event or not has_previous_frame:
            motion = None  # It goes on from a frame that has been forgotten, or from none.
        summary = self._step_filter(working_image, step.dt, motion)
        self._pictures = working_image.next_history
        event = joined_events(step.event, self._notice, summary.event)
        self._notice = ""
        return self._estimate(summary, step.dt, event, working_image.frame_scale)

    def _step_filter(
        self, image: WorkingImage, dt: float, motion: MotionAid | None
    ) -> BeliefSummary:
        if self._filter is None:
            self._filter = self._make_filter(image.frame_size)
        # Of this filter: another one's is converted when the parameters change.
        before: Any = self._belief
        # Taken out before it is used: one that fails must not fail with every frame that follows.
        given, self._given = self._given, None
        if given is not None:
            before, dt = self._given_belief(self._filter, given), 0.0
            motion = None  # It says where the cable is in this very frame.
            self._status = StatusMachine().confirm_with_next_frame()
        elif before is None:
            before = self._filter.first_belief()
        elif self._status.is_search_due(self._filter.search_time):
            before = self._filter.first_belief()
            self._status = self._status.searched()
        detections = NO_PROPOSALS
        if self._proposer is not None and not before.is_known(self._parameters):
            is_searching = before.is_searching(self._parameters)
            detections = self._proposer.propose(image, is_searching=is_searching)
        belief: Any = self._filter.step(before, image, dt, detections, motion)
        self._belief = belief
        return self._filter.summary(belief, image)

    def _given_belief(self, cable_filter: Filter, given: GivenState) -> ParticleBelief:
        """Return the belief in what an operator or planner gave about this very frame."""
        assert self._frame is not None
        width = self._frame.size[0]
        self._notice = _notice_of(given, state_limits(self._parameters, width))
        states = draw_given_states(given, self._parameters, width, self._rng)
        return cable_filter.given_belief(states, is_certain=given.is_certain)

    def _make_filter(self, image_size: tuple[int, int]) -> Filter:
        parameters = self._parameters
        if parameters.filter == "bootstrap":
            observation = make_observation(parameters, self._table)
            return BootstrapFilter(parameters, observation, image_size[0], self._rng)
        ratio = BorderLikelihoodRatio(parameters, self._table)
        return MultiHypothesisFilter(parameters, ratio, image_size, self._rng)

    def _estimate(
        self, summary: BeliefSummary, dt: float, event: str, frame_scale: float
    ) -> CableEstimate:
        assert self._frame is not None
        converged = self._has_converged(summary.covariance, frame_scale)
        self._status = self._status.after(
            supports_claim=converged and self._supports_claim(summary),
            supports_keeping=converged and summary.supports_keeping,
            contradicts_claim=summary.contradicts_claim,
            dt=dt,
            confirmation_time=self._parameters.confirmation_time,
            loss_time=self._parameters.loss_time,
        )
        return CableEstimate(
            stamp=self._frame.stamp,
            status=self._status.status,
            state=summary.hypotheses[0].state,
            covariance=summary.covariance,
            effective_sample_size=summary.effective_sample_size,
            evidence=summary.evidence,
            image_size=self._frame.size,
            event=event,
            presence=summary.presence,
            hypotheses=summary.hypotheses,
        )

    def _supports_claim(self, summary: BeliefSummary) -> bool:
        """Tell whether a frame speaks for claiming a cable.

        What an operator or planner gave is claimed for the first time by what suffices to keep a
        claim, as long as the filter follows it.
        """
        if self._status.status is TrackingStatus.INITIALISING and summary.follows_given:
            return summary.supports_keeping
        if self._status.is_first_claim(self._parameters.memory_time):
            return summary.supports_new_claim
        return summary.supports_claim

    def _has_converged(self, covariance: FloatArray, frame_scale: float) -> bool:
        sigma_distance = math.sqrt(covariance[DISTANCE, DISTANCE])
        sigma_angle = math.sqrt(covariance[ANGLE, ANGLE])
        return (
            sigma_distance <= self._parameters.converged_distance * frame_scale
            and sigma_angle <= math.radians(self._parameters.converged_angle)
        )


def _notice_of(given: GivenState, limits: StateLimits) -> str:
    """Return which limits a given state is moved into; empty if it is within them."""
    known = np.isfinite(given.sigma) | np.isnan(given.sigma)
    pose = np.where(known, given.state.to_array(), np.nan)[:POSE_SIZE]
    beyond = describe_limit_violations(pose, limits)
    return f"the given start is limited: {beyond}" if beyond else ""


def make_tracker(parameters: TrackerParameters) -> CableTracker:
    """Return a tracker of a cable.

    Raises
    ------
    ParameterError
        The response table cannot be read.
    """
    return CableTracker(parameters)


def warm_up(parameters: TrackerParameters) -> None:
    """Run a tracker of its own on a few frames, so that everything is compiled and loaded.

    The first time on a machine takes some seconds or more; later the machine code is on disk.

    Raises
    ------
    ParameterError
        The response table cannot be read.
    """
    count = min(parameters.particle_count, WARM_UP_PARTICLES)
    tracker = make_tracker(parameters.replaced({"particle_count": count}))
    frame = np.full((WARM_UP_HEIGHT, WARM_UP_WIDTH), 60, np.uint8)
    frame[:, WARM_UP_WIDTH // 2 - 20 : WARM_UP_WIDTH // 2 + 20] = 160
    for number in range(1, WARM_UP_FRAMES + 1):
        if number == WARM_UP_TOLD:
            tracker.initialise(GivenState.around(CableState(0.0, 0.0, 40.0)))
        tracker.process(frame, stamp=number * WARM_UP_STEP)


def make_proposer(parameters: TrackerParameters) -> LinePairProposer | None:
    """Return the detector that parameters name; the bootstrap filter asks none."""
    if parameters.filter == "bootstrap" or parameters.detector == "none":
        return None
    return LinePairProposer(pair_limits(parameters), uses_map=parameters.uses_map)
