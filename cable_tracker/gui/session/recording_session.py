"""A recording that is tracked in this process, at any pace, forwards and back."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path

from cable_tracker.cable.model.initial_state_text import RANDOM
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.errors import CableTrackerError, RecordingError
from cable_tracker.gui.session.session import AnyStart, Session
from cable_tracker.gui.session.session_trackers import (
    CableSessionTracker,
    SessionTracker,
    TargetSessionTracker,
)
from cable_tracker.gui.session.task_thread import TaskThread
from cable_tracker.gui.session.tracked_recording import TrackedRecording
from cable_tracker.metric.recorded_instruments import RecordedVehicle, recorded_vehicle
from cable_tracker.metric.targets.recorded_target import recorded_target
from cable_tracker.printable import printable
from cable_tracker.sequences.bags.instruments import InstrumentChoice
from cable_tracker.sequences.frame_access import FrameAccess
from cable_tracker.sequences.labels.target_labels import find_boxes, own_boxes
from cable_tracker.sequences.source import open_chosen
from cable_tracker.sequences.source_base import ChosenRecording, Source
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.parameter_table import ParameterSet, ParameterSpec, ParameterValue

LONGEST_PAUSE = 1.0
"""A longer one between two frames of a recording is shortened to this [s]."""

LARGEST_DELAY = 0.1
"""A player that is behind by more does not catch up [s]."""


@dataclass(frozen=True, slots=True)
class RecordingRequest(ChosenRecording):
    """Choices of the user about a recording.

    Attributes
    ----------
    init : str
        Initialisation: `random`, `truth`, a detector's name, or `d,alpha,w,beta` [px, rad].
    choice : InstrumentChoice
        Topics of the instruments.
    vehicle : Path or None
        The user's `vehicle.yaml`; None: the one in the bag's folder, if there is one.
    """

    init: str = RANDOM
    choice: InstrumentChoice = field(default_factory=InstrumentChoice)
    vehicle: Path | None = None

    def for_other(self, path: Path) -> RecordingRequest:
        """Return the request for another recording, opened like this one.

        Topics that were named and the vehicle file are those of the recording that was named with
        them, or of the first one that is opened if none was.
        """
        if self.path in (path, Path()):
            return replace(self, path=path)
        return replace(self, path=path, choice=InstrumentChoice(), vehicle=None)


class RecordingSession(Session):
    """Tracks a recording in a thread of its own, and can be played.

    Frames that follow each other are tracked as `cable-tracker track` does, with the same result.
    Going back to a frame that was tracked before under the same parameters gives the same belief
    again, bit for bit. On the way to one a little further on, the frames between are tracked; at
    any other one the tracker starts anew.

    Parameters
    ----------
    parameters : TrackerParameters or TargetParameters
        Initial parameters; their type decides between cable and target.

    Attributes
    ----------
    notes : tuple of str
        Remarks on the recording for the user.

    Raises
    ------
    RecordingError
        The recording is missing, empty, damaged before its first frame, or of no known kind.
    ParameterError
        There is no start as the request wants it, or the response table or the vehicle file cannot
        be read.
    """

    def __init__(self, request: RecordingRequest, parameters: ParameterSet) -> None:
        super().__init__()
        self.name = printable(request.path)
        self.request = request
        self._resources = ExitStack()
        with ExitStack() as stack:
            # Labels of a target are none of a cable, and are read by its tracker.
            is_target = isinstance(parameters, TargetParameters)
            opened = replace(request, truth=None) if is_target else request
            source = stack.enter_context(open_chosen(opened))
            self._frames = FrameAccess(source)
            vehicle = recorded_vehicle(source, request.choice, request.vehicle)
            tracker = _make_tracker(source, request, parameters, vehicle)
            try:
                self._frames.frame(0)
            except IndexError as error:
                raise RecordingError(f"{source.path}: holds no frames; record it again") from error
            notes = (*([source.note] if source.note else []), *vehicle.notes)
            self.notes = tuple(map(printable, notes))
            self._resources = stack.pop_all()
        self.subject = tracker.subject
        self.table: Sequence[ParameterSpec] = self.subject.session_table(is_live=False)
        self._tracked = TrackedRecording(self._frames, tracker, self._publish)
        self._trouble = ""
        self._is_playing = False
        self._speed = 1.0
        self._due = 0.0
        self._target: int | None = None
        self._heading: int | None = None
        self._lock = threading.Lock()
        self._thread = TaskThread(
            "recording", begin=self._begin, next_time=self._next_time, work=self._work
        )
        self._thread.start()

    # What can be asked at any time

    @property
    def trouble(self) -> str:
        """Trouble that keeps frames from coming, or else with the start; empty if there is none."""
        return printable(self._trouble or self._tracked.tracker.trouble)

    @property
    def is_enabled(self) -> bool:
        """Whether the tracker takes frames."""
        return self._tracked.is_enabled

    @property
    def frame_count(self) -> int | None:
        """Number of frames; None while it is unknown."""
        return self._frames.count

    @property
    def is_playing(self) -> bool:
        """Whether frames follow each other."""
        return self._is_playing

    @property
    def speed(self) -> float:
        """How fast it plays, as a multiple of the recording's own pace."""
        return self._speed

    def parameters(self) -> Mapping[str, ParameterValue]:
        """Return the values in force, by name."""
        return self._tracked.tracker.parameters()

    # Commands

    def play(self) -> None:
        """Let frames follow each other; from the start again if it stands at the end."""
        count = self._frames.count
        with self._lock:
            if count is not None and self._place() >= count - 1:
                self._target = 0
            self._due = 0.0
            self._is_playing = True
        self._thread.wake()

    def pause(self) -> None:
        """Stand still."""
        self._is_playing = False
        self._thread.wake()

    def step(self, count: int = 1) -> None:
        """Pause, and go some frames forwards, or backwards if negative."""
        with self._lock:
            self._is_playing = False
            self._target = self._within(self._place() + count)
        self._thread.wake()

    def seek(self, frame: int) -> None:
        """Go to a frame, or to the last one if there are fewer."""
        with self._lock:
            self._target = self._within(frame)
        self._thread.wake()

    def set_speed(self, speed: float) -> None:
        """Play faster or more slowly; infinity plays as fast as the tracker can."""
        if speed > 0.0:
            with self._lock:
                self._scale_pause(speed)
                self._speed = speed
        self._thread.wake()

    def _scale_pause(self, speed: float) -> None:
        """Scale what is left of the pause before the next frame to another speed."""
        now = time.monotonic()
        left = self._due - now
        if left > 0.0:
            self._due = now + left * self._speed / speed

    def change(self, values: Mapping[str, object]) -> None:
        """Change parameters, all of them or none; they count from the next frame on.

        Raises
        ------
        ParameterError
            A value is refused; nothing has changed.
        """
        self._thread.call(lambda: self._tracked.change(values))

    def initialise(self, start: AnyStart) -> None:
        """Start from what the user says: the next frame, or this one if it stands still.

        Raises
        ------
        FrameError
            The state of a cable is not finite, or a target's box lies outside the picture.
        GuiError
            The tracker is off.
        """
        self._thread.call(lambda: self._tracked.initialise(start, is_still=not self._is_playing))

    def reset(self) -> None:
        """Forget everything, from the next frame on, or from this one if it stands still."""
        self._thread.call(lambda: self._tracked.reset(is_still=not self._is_playing))

    def enable(self, wanted: bool) -> None:
        """Let the tracker take frames, or not. Switching on starts anew, as on the node."""
        self._thread.call(lambda: self._tracked.enable(wanted, is_still=not self._is_playing))

    def close(self) -> None:
        """End the thread and close the recording."""
        self._thread.close()
        self._tracked.tracker.close()
        self._resources.close()

    def _within(self, frame: int) -> int:
        count = self._frames.count
        return max(0, frame if count is None else min(frame, count - 1))

    def _place(self) -> int:
        """Return the frame that it goes to, or else is at: on the way there it goes by others."""
        for frame in (self._target, self._heading):
            if frame is not None:
                return frame
        return self._tracked.position

    # In the session's thread

    def _begin(self) -> None:
        """Show the first frame at once: the first time on a machine, compiling takes a while."""
        self._tracked.show_first()
        self._tracked.tracker.warm_up()
        self._go_to(0)

    def _next_time(self) -> float | None:
        if self._target is not None:
            return 0.0
        return self._due if self._is_playing else None

    def _work(self) -> None:
        with self._lock:
            target, self._target = self._target, None
            self._heading = target
        if target is None:
            self._play_on()
            return
        self._go_to(target)
        with self._lock:
            self._heading = None

    def _play_on(self) -> None:
        if self._has_next():
            begin = max(self._due, time.monotonic() - LARGEST_DELAY)
            self._go_to(self._tracked.position + 1)
            pause = self._pause_before_next()
            with self._lock:
                self._due = begin + pause / self._speed

    def _has_next(self) -> bool:
        """Tell whether there is another frame; if not, stand still."""
        try:
            self._frames.frame(self._tracked.position + 1)
        except IndexError:
            self._is_playing = False
            return False
        except RecordingError as error:
            self._stop(error)
            return False
        return True

    def _pause_before_next(self) -> float:
        """Return the time from this frame to the next in the recording [s]; 0 at its end."""
        now = self._frames.frame(self._tracked.position)
        if not self._has_next():
            return 0.0
        pause = (self._frames.frame(self._tracked.position + 1).stamp - now.stamp) / NANOSECONDS
        return min(max(0.0, pause), LONGEST_PAUSE)

    def _stop(self, error: CableTrackerError) -> None:
        self._trouble = str(error)
        self._is_playing = False

    def _go_to(self, target: int) -> None:
        try:
            if self._tracked.go_to(target, self._is_interrupted):
                self._trouble = ""
        except RecordingError as error:
            last = (self._frames.count or 0) - 1
            if 0 <= last < target:
                # The way to the last frame has shown that the recording breaks off before it.
                self._tracked.go_to(last, self._is_interrupted)
            self._stop(error)

    def _is_interrupted(self, is_target: bool) -> bool:
        """Tell whether another frame is wanted by now than the one on the way."""
        return self._thread.is_closing or (self._target is not None and not is_target)


def _make_tracker(
    source: Source,
    request: RecordingRequest,
    parameters: ParameterSet,
    vehicle: RecordedVehicle,
) -> SessionTracker:
    """Return a tracker of a cable or of a target, by the kind of parameters.

    Instruments tell metres of a cable, and turns of the camera for a target.
    """
    if isinstance(parameters, TargetParameters):
        truth = own_boxes(source) if request.truth is None else find_boxes(source, request.truth)
        instruments = recorded_target(vehicle) if vehicle.has_instruments else None
        return TargetSessionTracker(request.init, parameters, truth, instruments)
    assert isinstance(parameters, TrackerParameters)
    return CableSessionTracker(source, request.init, parameters, vehicle.instruments())
