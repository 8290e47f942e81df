"""Memory of what a tracker believed at earlier frames, so that one can go back to them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Protocol, Self, TypeVar

from cable_tracker.particle_filter.particles import Particles

FIRST_INTERVAL = 25
"""Frames between two remembered trackers, to begin with."""

LARGEST_COUNT = 128
"""Largest number of trackers that are remembered."""

LARGEST_PARTICLE_COUNT = 200_000
"""Largest number of particles of all remembered trackers; a few trackers are always remembered."""

LEAST_COUNT = 8


class Remembered(Protocol):
    """Interface of what is remembered: a tracker, or what holds one."""

    @property
    def particles(self) -> Particles | None:
        """The present belief."""
        ...

    def copy(self) -> Self:
        """Return another one that goes on as this one would."""
        ...


Tracker = TypeVar("Tracker", bound=Remembered)


@dataclass(slots=True, eq=False)
class _Stretch(Generic[Tracker]):
    """Frames that were tracked one after the other, and the tracker before the first of them.

    Attributes
    ----------
    tracker : Tracker
        Never used itself, only its copies.
    first, last : int
        Numbers of the frames.
    before : _Stretch or None
        The one that this goes on from, if nothing but frames has come between.
    is_given : bool
        Whether the user has said what is believed before the first frame: drawn, a reset, on.
    """

    tracker: Tracker
    first: int
    last: int
    before: _Stretch[Tracker] | None = None
    is_given: bool = False


class TrackerMemory(Generic[Tracker]):
    """Remembers copies of a tracker, every 25 frames to begin with.

    With many of them every other one is dropped and the interval is doubled: any frame that was
    tracked can still be reached, after some more frames that are tracked again on the way.
    """

    def __init__(self) -> None:
        self._stretches: list[_Stretch[Tracker]] = []
        self._current: _Stretch[Tracker] | None = None
        self._interval = FIRST_INTERVAL
        self._given: int | None = None

    def __len__(self) -> int:
        return len(self._stretches)

    def forget(self) -> None:
        """Forget everything."""
        self._stretches.clear()
        self._current = None
        self._interval = FIRST_INTERVAL

    def forget_from(self, frame: int) -> None:
        """Forget a frame and all after it: the user has changed what is believed there."""
        for stretch in self._stretches:
            stretch.last = min(stretch.last, frame - 1)
        self._drop_empty()
        self._current = None
        self._given = frame

    def interrupt(self) -> None:
        """Note that the next frame does not follow from those before."""
        self._current = None
        self._given = None

    def is_given(self, frame: int) -> bool:
        """Tell whether the user has changed what is believed there, other than in this run.

        Such a frame does not follow from the one before: the tracker is to be recalled for it.
        """
        return any(
            stretch.is_given and stretch.first == frame and stretch is not self._current
            for stretch in self._stretches
        )

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
        current = self._current
        if current is not None and frame <= current.last:
            return
        for stretch in self._stretches:
            if current is not None and stretch.before is current and stretch.first == frame:
                self._current = stretch
                return
        self._cut(frame)
        if current is not None and frame - current.first < self._interval:
            current.last = frame
            return
        is_given = self._given == frame
        self._current = _Stretch(tracker.copy(), frame, frame, current, is_given)
        self._given = None
        self._stretches.append(self._current)
        self._bound(len(tracker.particles.weights) if tracker.particles is not None else 1)

    def recall(self, frame: int) -> tuple[Tracker, int] | None:
        """Return the tracker from before a frame, as it was.

        Returns
        -------
        (Tracker, int) or None
            The tracker and the frame that it must be given next, which is the one asked for or one
            before it; None if the frame was never tracked.
        """
        for stretch in reversed(self._stretches):
            if stretch.first <= frame <= stretch.last:
                self._current = stretch
                self._given = None
                return stretch.tracker.copy(), stretch.first
        return None

    def _cut(self, frame: int) -> None:
        """Take a frame from all other stretches: it is about to be tracked otherwise."""
        for stretch in self._stretches:
            if stretch is not self._current and stretch.first <= frame <= stretch.last:
                stretch.last = frame - 1
        self._drop_empty()

    def _drop_empty(self) -> None:
        self._stretches = [stretch for stretch in self._stretches if stretch.first <= stretch.last]
        self._let_go()

    def _let_go(self) -> None:
        """Keep no tracker only because another one follows it."""
        for stretch in self._stretches:
            if stretch.before not in self._stretches:
                stretch.before = None

    def _bound(self, particle_count: int) -> None:
        most = min(LARGEST_COUNT, max(LEAST_COUNT, LARGEST_PARTICLE_COUNT // particle_count))
        if len(self._stretches) <= most:
            return
        before = len(self._stretches)
        self._interval *= 2
        self._thin()
        if len(self._stretches) == before:
            # Stretches between jumps are never joined, however long the interval is.
            self._interval //= 2
        for stretch in self._stretches[: max(0, len(self._stretches) - most)]:
            if stretch is not self._current:
                self._stretches.remove(stretch)
        self._let_go()

    def _thin(self) -> None:
        """Join stretches that follow each other, up to the length of the interval."""
        for stretch in tuple(self._stretches):
            before = stretch.before
            if (
                stretch is self._current
                or before not in self._stretches
                or before is None
                or before.last != stretch.first - 1
                or stretch.last - before.first >= self._interval
            ):
                continue
            before.last = stretch.last
            self._stretches.remove(stretch)
            for other in self._stretches:
                if other.before is stretch:
                    other.before = before
