"""Time of a controller that is called once for each frame."""

from __future__ import annotations

LONGEST_STEP = 1.0
"""Longest duration of one step in integrals [s]."""

LATE = 0.2
"""Largest step back of a frame that was overtaken; the tracker refuses it [s]."""

ROUNDING = 1e-6
"""Rounding error of differences between stamps in seconds [s]."""


class StepClock:
    """Adds up the time from step to step; steps back of the clock do not count.

    A step back of at most `LATE` sets no clock back: time stands still until the steps are past the
    newest one again.

    Attributes
    ----------
    now : float
        Time that has passed since the first step [s].
    was_set_back : bool
        Whether the time of the last step was before that of the step before, by more than `LATE`.
    """

    def __init__(self) -> None:
        self.now = 0.0
        self.was_set_back = False
        self._last: float | None = None

    def advance(self, time: float) -> float:
        """Return the time since the step before [s], at most `LONGEST_STEP`; 0 for the first.

        Parameters
        ----------
        time : float
            Time of this step, of any clock [s].
        """
        difference = 0.0 if self._last is None else time - self._last
        self.was_set_back = difference < -LATE - ROUNDING
        if self._last is None or difference > 0.0 or self.was_set_back:
            self._last = time
        passed = max(difference, 0.0)
        self.now += passed
        return min(passed, LONGEST_STEP)
