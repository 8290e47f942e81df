"""Time of a controller that is called once for each frame."""

from __future__ import annotations

LONGEST_STEP = 1.0
"""Longest time that one step counts for in what is integrated [s]."""


class StepClock:
    """Adds up the time from step to step; what a clock is set back by does not count.

    Attributes
    ----------
    now : float
        Time that has passed since the first step [s].
    """

    def __init__(self) -> None:
        self.now = 0.0
        self._last: float | None = None

    def advance(self, time: float) -> float:
        """Return the time since the step before [s], at most `LONGEST_STEP`; 0 for the first.

        Parameters
        ----------
        time : float
            Time of this step, of any clock [s].
        """
        passed = 0.0 if self._last is None else max(time - self._last, 0.0)
        self._last = time
        self.now += passed
        return min(passed, LONGEST_STEP)
