"""The target tracker: a frame and its time in, an estimate out."""

from __future__ import annotations

import copy
from enum import IntEnum
from typing import Any

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image, eight_bits
from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.target.candidates import DETECTORS
from cable_tracker.target.filter_interface import TargetBelief, TargetSummary
from cable_tracker.target.measure.working_frame import (
    WorkingFrame,
    check_target_frame,
    make_working_frame,
)
from cable_tracker.target.model.camera_motion import CameraMotion, usable_motion
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.target.model.start import TargetStart
from cable_tracker.target.model.state import (
    ANGLE,
    STATE_SIZE,
    UNKNOWN_COVARIANCE,
    X,
    Y,
    state_units,
    wrap_full_turn,
)
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.pose_filter import PoseFilter
from cable_tracker.target.thesis.blob_filter import BlobFilter
from cable_tracker.tracking.image_frame import to_pixel
from cable_tracker.tracking.level_gain import amplified, byte_gain
from cable_tracker.tracking.status import StatusMachine, TrackingStatus
from cable_tracker.tracking.succession import FrameMark, Succession, joined_events, succession

LONG_GONE = 3.0
"""Multiple of the memory's time for which what a detector proposed is lost before it proposes
again: by then the target is looked for in the whole picture."""

NO_OTHERS = np.empty((0, STATE_SIZE))

WARM_UP_WIDTH, WARM_UP_HEIGHT = 320, 240
WARM_UP_FRAMES = 3
WARM_UP_STEP = 40_000_000
"""Size of the frames of a warm-up [px], how many, and the time between them [ns]."""

WARM_UP_PARTICLES = 60
"""Number of particles of a warm-up; compilation does not depend on it."""

WARM_UP_WATER, WARM_UP_TARGET = (90, 80, 40), (30, 30, 200)
"""Colours of its picture [blue, green, red]."""


class FrameTask(IntEnum):
    """Use that a tracker makes of a frame."""

    START = 0
    """Take what was marked for the target."""
    FOLLOW = 1
    """Follow the target."""
    SEARCH = 2
    """Look for a target: none is followed, and none marked."""


class TargetTracker:
    """Follow one target with an outline through a sequence of frames.

    Parameters
    ----------
    parameters : TargetParameters
        The same parameters, frames and times give the same estimates, bit for bit.

    Examples
    --------
    >>> tracker = TargetTracker(TargetParameters(seed=1))
    >>> picture = np.full((240, 320, 3), (90, 80, 40), np.uint8)
    >>> picture[100:140, 150:190] = (30, 30, 200)
    >>> tracker.initialise(TargetStart.from_box(150, 100, 190, 140))
    >>> tracker.process(picture, stamp=1_000_000_000).status.value
    'TRACKING'
    """

    def __init__(self, parameters: TargetParameters | None = None) -> None:
        self._parameters = parameters if parameters is not None else TargetParameters()
        self._zoom = 1.0
        self.reset()

    @property
    def parameters(self) -> TargetParameters:
        """The parameters in force."""
        return self._parameters

    @property
    def particles(self) -> Particles | None:
        """The present belief, lengths in pixels of the frame; None before the first target."""
        if self._belief is None:
            return None
        particles = self._belief.particles
        return particles.moved_to(particles.states * state_units(self._zoom))

    def configure(self, parameters: TargetParameters) -> None:
        """Use other parameters from now on, and keep the belief.

        A changed seed waits for the next reset; another filter or working width starts anew with
        the next target that is marked or that the detector proposes. Where a marked one is lost by
        that, the next estimate says so.
        """
        before, self._parameters = self._parameters, parameters
        self._filter = self._make_filter()
        is_other = (before.filter, before.working_width) != (
            parameters.filter, parameters.working_width,
        )  # fmt: skip
        # A second change before the next frame finds nothing more to forget.
        if is_other and self._forget():
            self._notice = "another filter or working width"

    def reset(self) -> None:
        """Forget everything; the next frame is like the first, with the same random numbers."""
        self._rng = np.random.default_rng(self._parameters.seed)
        self._filter = self._make_filter()
        self._belief: TargetBelief | None = None
        self._gain = 1.0
        self._start: TargetStart | None = None
        self._status = StatusMachine()
        self._frame: FrameMark | None = None
        self._is_proposed = self._has_begun = False
        self._presence = 0.0
        self._notice = ""

    def copy(self) -> TargetTracker:
        """Return an independent tracker in the same state, which goes on bit for bit alike."""
        return copy.deepcopy(self, {id(self._parameters): self._parameters})

    def initialise(self, start: TargetStart) -> None:
        """Take what is marked in the next frame for the target, instead of the present one.

        Raises
        ------
        FrameError
            It lies outside the frames that came before, or is larger.
        """
        if self._frame is not None:
            start.check(self._frame.size)
        self._start = start

    def task_for(self, image: Image, stamp: int) -> FrameTask:
        """Check a frame, and return what `process` would do with it.

        Raises
        ------
        FrameError
            `process` would refuse it. Nothing has changed, but for a mark that the frame cannot
            hold: it is dropped.
        """
        step = self._succession(self._frame_mark(image, stamp))
        if self._start is not None:
            return FrameTask.START
        return (
            FrameTask.SEARCH if self._loses_target(step) or self.is_searching else FrameTask.FOLLOW
        )

    def _frame_mark(self, image: Image, stamp: int) -> FrameMark:
        check_target_frame(image, self._parameters.working_width)
        return FrameMark((image.shape[1], image.shape[0]), stamp)

    def _succession(self, frame: FrameMark) -> Succession:
        """Return how a frame follows the one before; see `task_for` for the errors."""
        if self._start is not None:
            try:
                self._start.check(frame.size)
            except FrameError:
                self._start = None
                raise
        return succession(self._frame, frame, self._parameters.maximum_gap)

    def process(
        self,
        image: Image,
        stamp: int,
        motion: CameraMotion | None = None,
        others: FloatArray = NO_OTHERS,
    ) -> TargetEstimate:
        """Take one frame into account.

        Parameters
        ----------
        image : Image
            Levels 0..255, uint8 or float32, blue-green-red (H, W, 3) or grey (H, W).
        stamp : int
            Time of the frame [ns].
        motion : CameraMotion or None
            Motion of the camera since the frame before. One that does not keep the picture before
            it counts as not known.
        others : FloatArray
            States of other targets in this frame, shape (K, 6), which this one keeps away from:
            those that are claimed; while it is searched for, all that are followed.

        Raises
        ------
        FrameError
            The frame cannot be used, has the same time as the frame before, or cannot hold what was
            marked in it. Nothing has changed, but for a mark that the frame cannot hold: it is
            dropped.
        """
        frame = self._frame_mark(image, stamp)
        step = self._succession(frame)
        start, self._start = self._start, None
        self._has_begun = False
        event = self._forget_before(step)
        self._frame = frame
        working = make_working_frame(self._in_bytes(image), self._parameters.working_width)
        self._zoom = working.zoom
        if start is not None:
            try:
                return self._begin(working, start, step.event)
            except FrameError as error:
                # It does not stand out: what was followed still is.
                event = joined_events(event, str(error))
                if self.is_searching:
                    return self._without_target(event)
        apart = others * state_units(1.0 / working.zoom)
        if self.is_searching:
            return self._search(working, event, apart)
        # After a gap the marked target may be anywhere that it can get to within the longest one.
        dt = self._parameters.maximum_gap if step.event else step.dt
        motion = usable_motion(motion, frame.size)
        # Of this filter: with another one the tracker starts anew.
        belief: Any = self._belief
        summary, self._belief = self._filter.step(
            belief, working, dt, motion, apart, counts_for=step.dt
        )
        return self._estimate(summary, step.dt, event)

    def _in_bytes(self, image: Image) -> Image:
        """Return a frame in 8 bits, amplified if it is deeper and dim.

        The gain stays while a target is followed, for that is known by its colours.
        """
        if self.is_searching:
            self._gain = byte_gain(image)
        return eight_bits(amplified(image, self._gain))

    def _forget_before(self, step: Succession) -> str:
        """Forget a target that cannot be followed into a frame; return the event to report."""
        notice, self._notice = self._notice, ""
        is_missed = (self._loses_target(step) and self._forget()) or bool(notice)
        reasons = joined_events(step.event, notice)
        return f"{reasons}: the marked target is forgotten, mark it again" if is_missed else reasons

    def _loses_target(self, step: Succession) -> bool:
        """Return whether the target of the frame before cannot be followed into a frame.

        A marked target is looked for until another mark, also after a gap; what a detector proposed
        is proposed again.
        """
        return bool(step.event) and (self._is_proposed or not step.is_same_size)

    def _forget(self) -> bool:
        """Drop the target, and return whether it was a marked one."""
        is_missed = self._belief is not None and not self._is_proposed
        self._belief = None
        self._status = StatusMachine()
        return is_missed

    @property
    def has_begun(self) -> bool:
        """Whether the last frame began with what was marked in it."""
        return self._has_begun

    @property
    def is_searching(self) -> bool:
        """Whether there is no target, or one of the detector that was refuted or is long lost."""
        if self._belief is None:
            return True
        if not self._is_proposed:
            return False
        if self._status.status is TrackingStatus.INITIALISING:
            return self._presence < self._parameters.presence_to_lose
        return self._status.is_search_due(LONG_GONE * self._parameters.memory_time)

    def _search(self, working: WorkingFrame, event: str, others: FloatArray) -> TargetEstimate:
        """Start with the likeliest candidate of the detector that stands out, if there is one."""
        if self._parameters.detector != "none":
            for candidate in DETECTORS[self._parameters.detector](working):
                if _covers_any(candidate.mask, others):
                    continue
                try:
                    summary, self._belief = self._filter.start(
                        working, candidate.mask, is_exact=True
                    )
                except FrameError:
                    # It does not stand out: the next candidate may.
                    continue
                self._is_proposed = True
                self._status = StatusMachine()
                return self._estimate(summary, 0.0, event)
        return self._without_target(event)

    def _make_filter(self) -> PoseFilter | BlobFilter:
        if self._parameters.filter == "blobs":
            return BlobFilter(self._parameters, self._rng)
        return PoseFilter(self._parameters, self._rng)

    def _begin(self, working: WorkingFrame, start: TargetStart, event: str) -> TargetEstimate:
        """Start with what was marked.

        Raises
        ------
        FrameError
            It does not stand out. Nothing has changed.
        """
        mask = start.mask(working.shape, working.zoom)
        summary, self._belief = self._filter.start(working, mask, is_exact=not start.is_box)
        self._status = StatusMachine().confirm_with_next_frame()
        self._is_proposed, self._has_begun = False, True
        return self._estimate(summary, 1.0, event)

    def _without_target(self, event: str) -> TargetEstimate:
        """Return the estimate of a frame without any target."""
        assert self._frame is not None
        return TargetEstimate(
            stamp=self._frame.stamp,
            status=self._status.status,
            image_size=self._frame.size,
            state=np.zeros(STATE_SIZE),
            covariance=UNKNOWN_COVARIANCE,
            event=event,
        )

    def _estimate(self, summary: TargetSummary, dt: float, event: str) -> TargetEstimate:
        assert self._frame is not None
        self._presence = summary.presence
        self._status = self._status.after(
            supports_claim=summary.supports_claim,
            supports_keeping=summary.supports_keeping,
            dt=dt,
            confirmation_time=self._parameters.confirmation_time,
            loss_time=self._parameters.loss_time,
        )
        units = state_units(self._zoom)
        state = summary.state * units
        # The filter goes on counting whole turns.
        state[ANGLE] = wrap_full_turn(state[ANGLE])
        outline = summary.outline
        box, corners, area = None, np.empty((0, 2)), 0.0
        if outline is not None:
            left, top, right, bottom = (side * self._zoom for side in outline.box)
            box = (left, top, right, bottom)
            corners = outline.corners(self._zoom)
            area = outline.area * self._zoom**2
        return TargetEstimate(
            stamp=self._frame.stamp,
            status=self._status.status,
            image_size=self._frame.size,
            state=state,
            covariance=summary.covariance * np.outer(units, units),
            box=box,
            outline=corners,
            area=area,
            is_whole=summary.is_whole,
            presence=summary.presence,
            effective_sample_size=summary.effective_sample_size,
            score=summary.score,
            event=event,
        )


def _covers_any(mask: BoolArray, others: FloatArray) -> bool:
    """Return whether a mask (H, W) contains the centre of one of the poses (K, 6)."""
    height, width = mask.shape
    places = to_pixel(others[:, X], others[:, Y], (width, height))
    columns, rows = (np.rint(each).astype(int) for each in places)
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    return bool(mask[rows[inside], columns[inside]].any())


def warm_up_target(parameters: TargetParameters) -> None:
    """Run trackers of its own on a few frames, in colour and in grey.

    The first time on a machine takes some seconds or more; later the machine code is on disk.
    """
    few = parameters.replaced({"particle_count": min(parameters.particle_count, WARM_UP_PARTICLES)})
    picture = np.full((WARM_UP_HEIGHT, WARM_UP_WIDTH, 3), WARM_UP_WATER, np.uint8)
    picture[90:150, 120:200] = WARM_UP_TARGET
    for frame in (picture, np.ascontiguousarray(picture[..., 2])):
        # Frames of messages cannot be written to, and are compiled for as another type.
        frame.setflags(write=False)
        tracker = TargetTracker(few)
        tracker.process(frame, stamp=WARM_UP_STEP)
        tracker.initialise(TargetStart.from_box(120, 90, 200, 150))
        for number in range(2, WARM_UP_FRAMES + 2):
            tracker.process(frame, stamp=number * WARM_UP_STEP)
