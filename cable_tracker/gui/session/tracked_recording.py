"""A recording's frames, tracked one after the other, and again after going back.

Copies of the tracker at earlier frames are kept, so that one can go back to them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from operator import itemgetter
from typing import Generic, Protocol, Self, TypeVar

from cable_tracker.errors import FrameError, GuiError
from cable_tracker.gui.session.session import AnySnapshot, AnyStart, Listener
from cable_tracker.gui.session.session_trackers import SessionTracker
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.frame_access import FrameAccess
from cable_tracker.tracking.status import DISABLED, REFUSED, WARMING_UP

FIRST_INTERVAL = 25
"""Frames between two remembered trackers, to begin with."""

LARGEST_COUNT = 128
"""Largest number of trackers that are remembered."""

LARGEST_PARTICLE_COUNT = 200_000
"""Largest number of particles of all remembered trackers; a few trackers are always remembered."""

LEAST_COUNT = 8

LONGEST_RUN = 25
"""Largest number of frames that are tracked on the way to one a little further on."""


class Remembered(Protocol):
    """Interface of what is remembered: a tracker, or what holds one."""

    @property
    def particles(self) -> Particles | None:
        """The present belief."""
        ...

    def copy(self) -> Self:
        """Return a copy that continues as this one would."""
        ...


Tracker = TypeVar("Tracker", bound=Remembered)


@dataclass(slots=True, eq=False)
class _Run:
    """Frames that were tracked one after the other.

    Attributes
    ----------
    first, last : int
        Numbers of the frames.
    is_given : bool
        Whether the user has said what is believed before the first frame: drawn, a reset, on.
    """

    first: int
    last: int
    is_given: bool


class TrackerMemory(Generic[Tracker]):
    """Remembers copies of a tracker, every 25 frames of a run to begin with.

    With many of them every other one is dropped and the interval is doubled: any frame that was
    tracked can still be reached, after some more frames that are tracked again on the way.
    """

    def __init__(self) -> None:
        # By the frame that each is to be given next, the oldest first; only copies are handed out.
        self._kept: dict[int, tuple[Tracker, _Run]] = {}
        self._run: _Run | None = None
        self._interval = FIRST_INTERVAL
        self._is_given = False

    def forget(self) -> None:
        """Forget everything."""
        self._kept.clear()
        self._run = None
        self._interval = FIRST_INTERVAL

    def forget_from(self, frame: int) -> None:
        """Forget a frame and all after it: the user has changed what is believed there."""
        self._kept = {first: each for first, each in self._kept.items() if first < frame}
        for _, run in self._kept.values():
            run.last = min(run.last, frame - 1)
        self._run = None
        self._is_given = True

    def interrupt(self) -> None:
        """Note that the next frame does not follow from those before."""
        self._run = None
        self._is_given = False

    def is_given(self, frame: int) -> bool:
        """Tell whether the user has changed what is believed there, other than in this run.

        Such a frame does not follow from the one before: the tracker is to be recalled for it.
        """
        if frame not in self._kept:
            return False
        _, run = self._kept[frame]
        return run.is_given and run.first == frame and run is not self._run

    def note(self, frame: int, tracker: Tracker) -> None:
        """Remember that a frame is about to be tracked, and the tracker if it is time.

        Parameters
        ----------
        frame : int
            Its number: one more than that of the last call, unless `interrupt`, `forget_from` or
            `recall` have come between.
        tracker : Tracker
            The tracker as it is before that frame.
        """
        if self._run is None:
            self._run = _Run(frame, frame, self._is_given)
            self._is_given = False
        elif frame <= self._run.last:
            return
        self._run.last = frame
        self._kept.pop(frame, None)  # Of another run, which this one has reached.
        nearest = self._nearest(frame)
        if nearest is not None:
            first, _, run = nearest
            if run is self._run and frame - first < self._interval:
                return
        self._kept[frame] = tracker.copy(), self._run
        self._bound(len(tracker.particles.weights) if tracker.particles is not None else 1)

    def recall(self, frame: int) -> tuple[Tracker, int] | None:
        """Return the tracker from before a frame, as it was.

        Returns
        -------
        (Tracker, int) or None
            The tracker and the frame that it must be given next, which is the one asked for or one
            before it; None if the frame was never tracked.
        """
        nearest = self._nearest(frame)
        if nearest is None:
            return None
        first, tracker, run = nearest
        if frame > run.last:
            return None
        self._run = run
        self._is_given = False
        return tracker.copy(), first

    def _nearest(self, frame: int) -> tuple[int, Tracker, _Run] | None:
        """Return the first frame, tracker and run of what is remembered nearest before a frame."""
        first = max((each for each in self._kept if each <= frame), default=None)
        return None if first is None else (first, *self._kept[first])

    def _bound(self, particle_count: int) -> None:
        most = min(LARGEST_COUNT, max(LEAST_COUNT, LARGEST_PARTICLE_COUNT // particle_count))
        count = len(self._kept)
        if count <= most:
            return
        self._interval *= 2
        self._thin()
        if len(self._kept) == count:
            # Starts of runs are never thinned, however long the interval is.
            self._interval //= 2
        for first in list(self._kept)[: max(0, len(self._kept) - most)]:
            del self._kept[first]

    def _thin(self) -> None:
        """Drop what comes less than the interval after another one of its run, but the newest."""
        newest = next(reversed(self._kept))
        before, run_before = 0, None
        for first, (_, run) in sorted(self._kept.items(), key=itemgetter(0)):
            if run is run_before and first - before < self._interval and first != newest:
                del self._kept[first]
            else:
                before, run_before = first, run


class TrackedRecording:
    """Goes to frames of a recording with a tracker that remembers; for one thread.

    Parameters
    ----------
    tracker : SessionTracker
        Tracks.
    publish : callable
        Told of every snapshot.

    Attributes
    ----------
    tracker : SessionTracker
        Tracks now; going back puts an earlier one in its place.
    position : int
        The frame that was tracked last; -1 before the first.
    is_enabled : bool
        Whether the tracker takes frames.
    """

    def __init__(self, frames: FrameAccess, tracker: SessionTracker, publish: Listener) -> None:
        self._frames = frames
        self.tracker = tracker
        self._publish = publish
        self._memory: TrackerMemory[SessionTracker] = TrackerMemory()
        self.position = -1
        self.is_enabled = True
        self._number = 0

    def show_first(self) -> None:
        """Show the first frame without tracking it: there may be code to compile before that."""
        frame = self._frames.frame(0)
        with suppress(FrameError):
            self.tracker.decode(frame)
        self._publish(self._snapshot(frame, WARMING_UP))

    def go_to(self, target: int, is_interrupted: Callable[[bool], bool]) -> bool:
        """Track a frame, or the last one, and before it those that an unbroken run would track.

        Parameters
        ----------
        target : int
            Number of the frame.
        is_interrupted : callable
            Asked before each frame whether to stop there; told whether it is the target.

        Returns
        -------
        bool
            Whether the frame has been reached, and was not the present one.

        Raises
        ------
        RecordingError
            The recording is damaged before or at it.
        """
        if target == self.position:
            return False
        try:
            self._frames.frame(target)
            first = self.position + 1
            if target != first or target == 0 or not self.is_enabled:
                first = self._recall(target)
            for number in range(first, target + 1):
                if is_interrupted(number == target):
                    self.position = number - 1
                    return False
                if self.is_enabled and self._memory.is_given(number):
                    self._take_remembered(number)
                self._track(self._frames.frame(number), is_shown=number == target)
        except IndexError:
            last = (self._frames.count or 0) - 1
            return 0 <= last < target and self.go_to(last, is_interrupted)
        return True

    def _recall(self, target: int) -> int:
        """Take the tracker from before a frame; returns the frame that it needs next."""
        if not self.is_enabled:
            return target
        first = self._take_remembered(target)
        if first is not None:
            return first
        if 0 <= self.position < target <= self.position + LONGEST_RUN:
            return self.position + 1
        self._memory.interrupt()
        self.tracker.reset()
        if target == 0:
            self.tracker.begin()
        return target

    def _take_remembered(self, target: int) -> int | None:
        """Go on with the tracker that was remembered for a frame; None if there is none."""
        remembered = self._memory.recall(target)
        if remembered is None:
            return None
        self.tracker.close()
        self.tracker, first = remembered
        return first

    def _track(self, frame: Frame, *, is_shown: bool = True) -> None:
        self.position = frame.index
        if self.is_enabled:
            # A frame that is refused belongs to the run too: one can go back to it and on from it.
            self._memory.note(frame.index, self.tracker)
        try:
            self.tracker.decode(frame)
            if not self.is_enabled:
                self._publish(self._snapshot(frame, DISABLED))
                return
            snapshot = self.tracker.follow(frame, self._number + 1)
        except FrameError as error:
            if is_shown:
                self._publish(self._snapshot(frame, REFUSED, str(error)))
            return
        if is_shown:
            self._number += 1
            self._publish(snapshot)

    def _snapshot(self, frame: Frame, status: str, reason: str = "") -> AnySnapshot:
        self._number += 1
        return self.tracker.show(frame, self._number, status, reason)

    def change(self, values: Mapping[str, object]) -> None:
        """Change parameters from the next frame on; see `SessionTracker.configure`."""
        if self.tracker.configure(values):
            self._memory.forget()

    def initialise(self, start: AnyStart, *, is_still: bool) -> None:
        """Start from what the user says with the next frame, or with this one while it is still.

        Raises
        ------
        GuiError
            The tracker is off; when it is switched on it starts anew.
        """
        if not self.is_enabled:
            raise GuiError(
                "the tracker is off, and starts anew when it goes on; switch it on first"
            )
        if not is_still:
            self.tracker.initialise(start)
            self._memory.forget_from(self.position + 1)
            return
        # Refused here if at all, before anything is forgotten.
        self.tracker.initialise(start)
        self.tracker.reset()
        self.tracker.initialise(start)
        self._track_again()

    def reset(self, *, is_still: bool) -> None:
        """Forget everything from the next frame on, or from this one while it is still."""
        self.tracker.reset()
        if not is_still or not self.is_enabled:
            self._memory.forget_from(self.position + 1)
        else:
            self._track_again()

    def enable(self, wanted: bool, *, is_still: bool) -> None:
        """Let the tracker take frames, or not; it starts anew."""
        if wanted and not self.is_enabled:
            self.tracker.reset()
        self.is_enabled = wanted
        self._memory.forget_from(self.position + 1)
        if is_still:
            self._track_again()

    def _track_again(self) -> None:
        """Track the frame that is shown once more, with a tracker that knows nothing of it."""
        self._memory.forget_from(self.position)
        self._track(self._frames.frame(self.position))
