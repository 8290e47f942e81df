"""Trackers as a recording session uses them: frame in, snapshot out, whatever is followed."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Protocol, Self

import numpy as np

from cable_tracker.arrays import FloatArray, Image, eight_bits
from cable_tracker.cable.model.estimate import CableEstimate, TrackingStatus
from cable_tracker.cable.model.initial_state import GivenState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.tracker import CableTracker
from cable_tracker.detection.pair_limits import pair_limits
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.tracking.track_recording import initial_state_for, start_from
from cable_tracker.gui.recording_request import RecordingRequest
from cable_tracker.gui.session import AnySnapshot, AnyStart, Snapshot, TargetSnapshot
from cable_tracker.gui.subject import CABLE, TARGET, Subject
from cable_tracker.metric.recorded import RecordedMetres, RecordedVehicle
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences.encodings import decode_bgr, decode_grey
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages import cloud_of
from cable_tracker.sequences.source import Source
from cable_tracker.sequences.target_labels import BoxTruth, find_boxes, own_boxes
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.model.start_text import StartText, parse_start_text
from cable_tracker.target.model.state import PoseColumn
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.tracker import TargetTracker
from cable_tracker.target.warming import warm_up_target
from cable_tracker.trackers import make_proposer, make_tracker, warm_up
from cable_tracker.tracking.parameter_table import ParameterSet, ParameterValue

BLANK = np.zeros((240, 320), np.uint8)
"""Shown where no frame could be decoded yet."""

UNTRACKED = Withheld(Reason.NOT_TRACKING, "this frame was not tracked")
"""Said in place of metres."""


class AnyTracker(Protocol):
    """What the trackers of all subjects have in common."""

    @property
    def particles(self) -> Particles | None:
        """The present belief."""
        ...

    def reset(self) -> None:
        """Forget everything."""
        ...

    def copy(self) -> Self:
        """Return another one that goes on as this one would."""
        ...


class Follower(ABC):
    """A tracker, and what a session wants to know of it.

    Attributes
    ----------
    subject : Subject
        What is followed.
    """

    subject: Subject
    _tracker: AnyTracker
    _parameters: ParameterSet

    @property
    def particles(self) -> Particles | None:
        """The present belief."""
        return self._tracker.particles

    def parameters(self) -> Mapping[str, ParameterValue]:
        """Return the values in force, by name."""
        return self._parameters.as_mapping()

    @abstractmethod
    def warm_up(self) -> None:
        """Compile and load what frames will need."""

    @abstractmethod
    def begin(self) -> None:
        """Be ready for the first frame of the recording, with the start that was asked for."""

    def reset(self) -> None:
        """Forget everything."""
        self._tracker.reset()

    def copy(self) -> Self:
        """Return another one that goes on as this one would."""
        other = self.__new__(type(self))
        other.__dict__ = self.__dict__ | {"_tracker": self._tracker.copy()}
        return other

    @abstractmethod
    def initialise(self, start: AnyStart) -> None:
        """Start the next frame from what the user says.

        Raises
        ------
        FrameError
            It cannot be; nothing has changed.
        """

    def configure(self, values: Mapping[str, object]) -> bool:
        """Change parameters, all or none; tell whether any has another value now.

        Raises
        ------
        ParameterError
            A value is refused.
        """
        parameters = self._parameters.replaced(values)
        if parameters == self._parameters:
            return False
        self._configure_tracker(parameters)
        self._parameters = parameters
        return True

    @abstractmethod
    def close(self) -> None:
        """Read no more of the recording."""

    @abstractmethod
    def _configure_tracker(self, parameters: ParameterSet) -> None:
        """Let the tracker go on with other parameters."""

    @abstractmethod
    def look(self, frame: Frame) -> None:
        """Decode a frame, which is shown from now on.

        Raises
        ------
        FrameError
            It cannot be decoded.
        """

    @abstractmethod
    def follow(self, frame: Frame, number: int) -> AnySnapshot:
        """Track the frame that was looked at last; its snapshot gets a number.

        Raises
        ------
        FrameError
            It cannot be used.
        """

    @abstractmethod
    def show(self, frame: Frame, number: int, status: str, reason: str = "") -> AnySnapshot:
        """Return a snapshot of a frame that is not tracked."""


class CableFollower(Follower):
    """Follows a cable.

    Parameters
    ----------
    source : Source
        The recording.
    init : str
        Where to start in it.
    parameters : TrackerParameters
        Those to begin with.
    metres : RecordedMetres or None
        The recording's instruments; None: everything stays in pixels.

    Raises
    ------
    ParameterError
        There is no such start, or the response table cannot be read.
    """

    subject = CABLE
    _tracker: CableTracker
    _parameters: TrackerParameters

    def __init__(
        self,
        source: Source,
        init: str,
        parameters: TrackerParameters,
        metres: RecordedMetres | None = None,
    ) -> None:
        self._start = initial_state_for(source, init, pair_limits(parameters))
        self._parameters = parameters
        self._tracker = make_tracker(parameters)
        self._metres = metres
        self._decoded: Image = BLANK
        self._grey: Image = BLANK

    def warm_up(self) -> None:
        """Compile and load what frames will need."""
        warm_up(self._parameters)

    def begin(self) -> None:
        """Be ready for the first frame."""
        start_from(self._tracker, self._start)
        if self._metres is not None:
            self._metres.jump(to_start=True)

    def reset(self) -> None:
        """Forget everything."""
        super().reset()
        if self._metres is not None:
            self._metres.jump()

    def copy(self) -> Self:
        """Return another one that goes on as this one would."""
        other = super().copy()
        if self._metres is not None:
            other._metres = self._metres.copy()
        return other

    def close(self) -> None:
        """Read no more of the recording."""
        if self._metres is not None:
            self._metres.close()

    def initialise(self, start: AnyStart) -> None:
        """Start the next frame from a belief."""
        assert isinstance(start, GivenState), "a cable is not marked with an outline"
        self._tracker.initialise(start)

    def _configure_tracker(self, parameters: ParameterSet) -> None:
        assert isinstance(parameters, TrackerParameters)
        self._tracker.configure(parameters, make_proposer(parameters))

    def look(self, frame: Frame) -> None:
        """Decode a frame."""
        self._decoded = decode_grey(frame.image)
        self._grey = eight_bits(self._decoded)

    def follow(self, frame: Frame, number: int) -> Snapshot:
        """Track a frame."""
        metres = self._metres
        if metres is not None:
            metres.advance(frame)
        begin = time.perf_counter()
        motion = metres.motion(frame.stamp, self._decoded) if metres is not None else None
        estimate = self._tracker.process(self._decoded, frame.stamp, motion)
        ms = (time.perf_counter() - begin) * 1e3
        snapshot = self._tracked(frame, number, estimate, ms)
        if metres is None:
            return snapshot
        metres.observe(estimate)
        return replace(snapshot, metres=metres.measure(estimate))

    def show(self, frame: Frame, number: int, status: str, reason: str = "") -> Snapshot:
        """Return a snapshot of a frame that is not tracked."""
        return Snapshot(
            number=number,
            frame=frame.index,
            stamp=frame.stamp,
            grey=self._grey,
            status=status,
            reason=reason,
            truth=frame.truth,
            metres=None if self._metres is None else UNTRACKED,
        )

    def _tracked(self, frame: Frame, number: int, estimate: CableEstimate, ms: float) -> Snapshot:
        is_claimed = estimate.status is TrackingStatus.TRACKING
        particles = self._tracker.particles
        return Snapshot(
            number=number,
            frame=frame.index,
            stamp=frame.stamp,
            grey=self._grey,
            status=estimate.status.value,
            reason=estimate.event,
            state=estimate.state if is_claimed else None,
            sigma=estimate.standard_deviations() if is_claimed else None,
            cloud=cloud_of(particles) if particles is not None else None,
            hypotheses=estimate.hypotheses,
            presence=estimate.presence,
            evidence=estimate.evidence if math.isfinite(estimate.evidence) else None,
            n_eff=estimate.effective_sample_size,
            ms=ms,
            truth=frame.truth,
        )


class TargetFollower(Follower):
    """Follows a target.

    Parameters
    ----------
    init : str
        Where to start: `wait` for a mark, `detect`, or `x0,y0,x1,y1` [px].
    parameters : TargetParameters
        Those to begin with.
    truth : BoxTruth
        Where the target really is, as far as that is known.

    Raises
    ------
    ParameterError
        There is no such start.
    """

    subject = TARGET
    _tracker: TargetTracker
    _parameters: TargetParameters

    def __init__(self, init: str, parameters: TargetParameters, truth: BoxTruth) -> None:
        self._truth = truth
        self._start: StartText = parse_start_text(init)
        if len(self._start.boxes) > 1:
            raise ParameterError("init: the window follows one target; mark only one")
        if self._start.detects:
            parameters = parameters.with_detector()
        self._parameters = parameters
        self._tracker = TargetTracker(parameters)
        self._image: Image = BLANK

    def warm_up(self) -> None:
        """Compile and load what frames will need."""
        warm_up_target(self._parameters)

    def begin(self) -> None:
        """Be ready for the first frame."""
        for start in self._start.boxes:
            self._tracker.initialise(start)

    def close(self) -> None:
        """Do nothing: boxes were read at the start."""

    def initialise(self, start: AnyStart) -> None:
        """Follow what is marked in the next frame."""
        assert isinstance(start, TargetStart), "a target is marked with a box or an outline"
        height, width = self._image.shape[:2]
        start.check((width, height))
        self._tracker.initialise(start)

    def _configure_tracker(self, parameters: ParameterSet) -> None:
        assert isinstance(parameters, TargetParameters)
        self._tracker.configure(parameters)

    def look(self, frame: Frame) -> None:
        """Decode a frame."""
        self._image = decode_bgr(frame.image)

    def follow(self, frame: Frame, number: int) -> TargetSnapshot:
        """Track a frame."""
        begin = time.perf_counter()
        estimate = self._tracker.process(self._image, frame.stamp)
        ms = (time.perf_counter() - begin) * 1e3
        is_claimed = estimate.status is TrackingStatus.TRACKING and estimate.box is not None
        state = sigma = None
        if is_claimed:
            state = estimate.state.copy()
            state[PoseColumn.LOG_SCALE] = estimate.scale
            sigma = estimate.standard_deviations()[:4]
            sigma[PoseColumn.LOG_SCALE] *= estimate.scale
        return TargetSnapshot(
            number=number,
            frame=frame.index,
            stamp=frame.stamp,
            image=self._image,
            status=estimate.status.value,
            reason=estimate.event,
            state=state,
            sigma=sigma,
            box=estimate.box if is_claimed else None,
            outline=estimate.outline if is_claimed else np.empty((0, 2)),
            area=estimate.area if is_claimed else None,
            cloud=_poses_of(self._tracker.particles),
            score=float(estimate.score),
            presence=float(estimate.presence),
            n_eff=float(estimate.effective_sample_size),
            ms=ms,
            truth=self._truth.box(frame),
        )

    def show(self, frame: Frame, number: int, status: str, reason: str = "") -> TargetSnapshot:
        """Return a snapshot of a frame that is not tracked."""
        return TargetSnapshot(
            number=number,
            frame=frame.index,
            stamp=frame.stamp,
            image=self._image,
            status=status,
            reason=reason,
            truth=self._truth.box(frame),
        )


def _poses_of(particles: Particles | None) -> FloatArray | None:
    """Return the columns of `TargetSnapshot.state` and the weight of each particle, (N, 7)."""
    if particles is None:
        return None
    cloud = np.column_stack((particles.states, particles.weights))
    cloud[:, PoseColumn.LOG_SCALE] = np.exp(cloud[:, PoseColumn.LOG_SCALE])
    return cloud


def open_for(request: RecordingRequest, parameters: ParameterSet) -> Source:
    """Open a recording; labels of a target are none of a cable, and are read by its follower."""
    is_target = isinstance(parameters, TargetParameters)
    return (replace(request, truth=None) if is_target else request).open()


def make_follower(
    source: Source,
    request: RecordingRequest,
    parameters: ParameterSet,
    vehicle: RecordedVehicle | None = None,
) -> Follower:
    """Return what follows what the parameters are for.

    Parameters
    ----------
    source : Source
        The recording.
    request : RecordingRequest
        How it was opened.
    parameters : TrackerParameters or TargetParameters
        Those to begin with.
    vehicle : RecordedVehicle or None
        Its instruments, for a cable in metres.

    Raises
    ------
    ParameterError
        There is no such start.
    RecordingError
        The labels cannot be read.
    """
    if isinstance(parameters, TargetParameters):
        truth = own_boxes(source) if request.truth is None else find_boxes(source, request.truth)
        return TargetFollower(request.init, parameters, truth)
    assert isinstance(parameters, TrackerParameters)
    metres = vehicle.metres() if vehicle is not None else None
    return CableFollower(source, request.init, parameters, metres)
