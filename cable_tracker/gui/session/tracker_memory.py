"""Copies of a tracker at earlier frames, so that one can go back to them."""

from __future__ import annotations

from dataclasses import dataclass
from operator import itemgetter
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
