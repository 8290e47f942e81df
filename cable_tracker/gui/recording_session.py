"""A recording that is tracked in this process, at any pace, forwards and back."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress

from cable_tracker.errors import CableTrackerError, FrameError, RecordingError
from cable_tracker.gui.followers.choice import make_follower, open_for
from cable_tracker.gui.followers.follower import Follower
from cable_tracker.gui.recording_request import RecordingRequest
from cable_tracker.gui.session import AnySnapshot, AnyStart
from cable_tracker.gui.snapshot_feed import SnapshotFeed
from cable_tracker.gui.task_thread import TaskThread
from cable_tracker.gui.tracker_memory import TrackerMemory
from cable_tracker.metric.recorded import RecordedVehicle, recorded_vehicle
from cable_tracker.sequences.estimates import REFUSED
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.frame_access import FrameAccess
from cable_tracker.sequences.source import Source
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.idle_status import DISABLED, WARMING_UP
from cable_tracker.tracking.parameter_table import ParameterSet, ParameterSpec, ParameterValue

LONGEST_PAUSE = 1.0
"""A longer one between two frames of a recording is shortened to this [s]."""

LONGEST_RUN = 25
"""Frames on the way to one a little further on are tracked, up to so many."""

LARGEST_DELAY = 0.1
"""A player that is behind by more does not catch up [s]."""


class RecordingSession(SnapshotFeed):
    """Tracks a recording in a thread of its own; a `Player`.

    Frames that follow each other are tracked as `cable-tracker track` does, with the same result.
    Going back to a frame that was tracked before under the same parameters gives the same belief
    again, bit for bit. On the way to one a little further on, the frames between are tracked; at
    any other one the tracker starts anew.

    Parameters
    ----------
    request : RecordingRequest
        The recording.
    parameters : TrackerParameters or TargetParameters
        Those to begin with; they say what is followed.

    Attributes
    ----------
    notes : tuple of str
        What the user should know about the recording.

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
        self.name = str(request.path)
        self.request = request
        self._resources = ExitStack()
        with ExitStack() as stack:
            source = stack.enter_context(open_for(request, parameters))
            self._frames = FrameAccess(source)
            vehicle = self._instruments_of(source, parameters)
            self._follower = make_follower(source, request, parameters, vehicle)
            try:
                self._frames.frame(0)
            except IndexError as error:
                raise RecordingError(f"{source.path}: holds no frames; record it again") from error
            self.notes = (
                *([source.note] if source.note else []),
                *(vehicle.notes if vehicle else ()),
            )
            self._resources = stack.pop_all()
        self.subject = self._follower.subject
        self.table: Sequence[ParameterSpec] = self.subject.session_table(is_live=False)
        self._memory: TrackerMemory[Follower] = TrackerMemory()
        self._position = -1
        self._number = 0
        self._trouble = ""
        self._is_enabled = True
        self._is_playing = False
        self._speed = 1.0
        self._due = 0.0
        self._target: int | None = None
        self._lock = threading.Lock()
        self._thread = TaskThread(
            "recording", begin=self._begin, next_time=self._next_time, work=self._work
        )
        self._thread.start()

    def _instruments_of(self, source: Source, parameters: ParameterSet) -> RecordedVehicle | None:
        """Return what a recording of a cable holds besides pictures; a target stays in pixels."""
        if isinstance(parameters, TargetParameters):
            return None
        return recorded_vehicle(source, self.request.choice, self.request.vehicle)

    # What can be asked at any time

    @property
    def trouble(self) -> str:
        """What keeps frames from coming; empty if nothing."""
        return self._trouble

    @property
    def is_enabled(self) -> bool:
        """Whether the tracker takes frames."""
        return self._is_enabled

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
        return self._follower.parameters()

    # Commands

    def play(self) -> None:
        """Let frames follow each other; from the start again if it stands at the end."""
        count = self._frames.count
        with self._lock:
            place = self._target if self._target is not None else self._position
            if count is not None and place >= count - 1:
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
            start = self._target if self._target is not None else self._position
            self._target = self._within(start + count)
        self._thread.wake()

    def seek(self, frame: int) -> None:
        """Go to a frame, or to the last one if there are not so many."""
        with self._lock:
            self._target = self._within(frame)
        self._thread.wake()

    def set_speed(self, speed: float) -> None:
        """Play faster or more slowly; infinity plays as fast as the tracker can."""
        if speed > 0.0:
            self._speed = speed
        self._thread.wake()

    def change(self, values: Mapping[str, object]) -> None:
        """Change parameters, all of them or none; they count from the next frame on.

        Raises
        ------
        ParameterError
            A value is refused; nothing has changed.
        """
        self._thread.call(lambda: self._change(values))

    def initialise(self, start: AnyStart) -> None:
        """Start from what the user says: the next frame, or this one if it stands still.

        Raises
        ------
        FrameError
            It is not finite, or lies outside the picture.
        """
        self._thread.call(lambda: self._initialise(start))

    def reset(self) -> None:
        """Forget everything, from the next frame on, or from this one if it stands still."""
        self._thread.call(self._reset)

    def enable(self, wanted: bool) -> None:
        """Let the tracker take frames, or not. Switching on starts anew, as on the node."""
        self._thread.call(lambda: self._enable(wanted))

    def close(self) -> None:
        """End the thread and close the recording."""
        self._thread.close()
        self._follower.close()
        self._resources.close()

    def _within(self, frame: int) -> int:
        count = self._frames.count
        return max(0, frame if count is None else min(frame, count - 1))

    # In the session's thread

    def _begin(self) -> None:
        """Show the first frame at once: the first time on a machine, compiling takes a while."""
        frame = self._frames.frame(0)
        with suppress(FrameError):
            self._follower.look(frame)
        self._publish(self._snapshot(frame, WARMING_UP))
        self._follower.warm_up()
        self._go_to(0)

    def _next_time(self) -> float | None:
        if self._target is not None:
            return 0.0
        return self._due if self._is_playing else None

    def _work(self) -> None:
        with self._lock:
            target, self._target = self._target, None
        if target is not None:
            self._go_to(target)
        else:
            self._play_on()

    def _play_on(self) -> None:
        if self._has_next():
            begin = max(self._due, time.monotonic() - LARGEST_DELAY)
            self._go_to(self._position + 1)
            self._due = begin + self._pause_before_next() / self._speed

    def _has_next(self) -> bool:
        """Tell whether there is another frame; if not, stand still."""
        try:
            self._frames.frame(self._position + 1)
        except IndexError:
            self._is_playing = False
            return False
        except RecordingError as error:
            self._stop(error)
            return False
        return True

    def _pause_before_next(self) -> float:
        """Return the time from this frame to the next in the recording [s]; 0 at its end."""
        now = self._frames.frame(self._position)
        if not self._has_next():
            return 0.0
        pause = (self._frames.frame(self._position + 1).stamp - now.stamp) / NANOSECONDS
        return min(max(0.0, pause), LONGEST_PAUSE)

    def _stop(self, error: CableTrackerError) -> None:
        self._trouble = str(error)
        self._is_playing = False

    def _go_to(self, target: int) -> None:
        """Track a frame, and before it those that an unbroken run would have tracked."""
        if target == self._position:
            return
        try:
            self._frames.frame(target)
            first = self._position + 1
            if target != first or target == 0 or not self._is_enabled:
                first = self._recall(target)
            for number in range(first, target + 1):
                if self._thread.is_closing or (self._target is not None and number < target):
                    # Another frame is wanted by now.
                    self._memory.interrupt()
                    self._position = number - 1
                    return
                self._track(self._frames.frame(number), is_shown=number == target)
        except IndexError:
            last = (self._frames.count or 0) - 1
            if 0 <= last < target:
                self._go_to(last)
            return
        except RecordingError as error:
            self._stop(error)
            return
        self._trouble = ""

    def _recall(self, target: int) -> int:
        """Take the tracker from before a frame; returns the frame that it needs next."""
        if not self._is_enabled:
            return target
        remembered = self._memory.recall(target)
        if remembered is not None:
            self._follower.close()
            self._follower, first = remembered
            return first
        if 0 <= self._position < target <= self._position + LONGEST_RUN:
            return self._position + 1
        self._memory.interrupt()
        self._follower.reset()
        if target == 0:
            self._follower.begin()
        return target

    def _track(self, frame: Frame, *, is_shown: bool = True) -> None:
        self._position = frame.index
        try:
            self._follower.look(frame)
            if not self._is_enabled:
                self._publish(self._snapshot(frame, DISABLED))
                return
            self._memory.note(frame.index, self._follower)
            snapshot = self._follower.follow(frame, self._number + 1)
        except FrameError as error:
            if is_shown:
                self._publish(self._snapshot(frame, REFUSED, str(error)))
            return
        if is_shown:
            self._number += 1
            self._publish(snapshot)

    def _snapshot(self, frame: Frame, status: str, reason: str = "") -> AnySnapshot:
        self._number += 1
        return self._follower.show(frame, self._number, status, reason)

    def _change(self, values: Mapping[str, object]) -> None:
        if self._follower.configure(values):
            self._memory.forget()

    def _initialise(self, start: AnyStart) -> None:
        if self._is_playing or not self._is_enabled:
            self._follower.initialise(start)
            self._memory.forget_from(self._position + 1)
            return
        # Refused here if at all, before anything is forgotten.
        self._follower.initialise(start)
        self._follower.reset()
        self._follower.initialise(start)
        self._track_again()

    def _reset(self) -> None:
        self._follower.reset()
        if self._is_playing or not self._is_enabled:
            self._memory.forget_from(self._position + 1)
        else:
            self._track_again()

    def _enable(self, wanted: bool) -> None:
        if wanted and not self._is_enabled:
            self._follower.reset()
        self._is_enabled = wanted
        self._memory.forget_from(self._position + 1)
        if not self._is_playing:
            self._track_again()

    def _track_again(self) -> None:
        """Track the frame that is shown once more, with a tracker that knows nothing of it."""
        self._memory.forget_from(self._position)
        self._track(self._frames.frame(self._position))
