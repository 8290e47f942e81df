"""A recording's frames, tracked one after the other, and again after going back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress

from cable_tracker.errors import FrameError, GuiError
from cable_tracker.gui.session.session import AnyStart, Listener
from cable_tracker.gui.session.session_trackers.session_tracker import SessionTracker
from cable_tracker.gui.session.snapshot import AnySnapshot
from cable_tracker.gui.session.tracker_memory import TrackerMemory
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.frame_access import FrameAccess
from cable_tracker.tracking.status import DISABLED, REFUSED, WARMING_UP

LONGEST_RUN = 25
"""Largest number of frames that are tracked on the way to one a little further on."""


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
