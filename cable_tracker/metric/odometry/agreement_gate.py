"""Whether odometry agrees with how the filter sees the cable move."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.odometry.motion import CABLE_DISAGREES, NOT_PROVED, Unaided

WINDOW = 12
"""Frames over which predicted and observed motion are compared."""

FEWEST = 5
"""Smallest number of frames for a judgement."""

LARGEST_DRIFT = 4.0
"""Largest drift of predictions over the window [standard deviations]."""

LARGEST_STEP = 2.0
"""Largest error of predictions in half of the frames [standard deviations]."""

AGREEMENT = 0.6
"""Share of both limits below which there is agreement."""

CALM_FRAMES = 15
"""Number of frames in a row with agreement before the filter is aided."""


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    """One frame: what it showed beside what was predicted of d and alpha.

    `residual` (2,), `unknown` (2,) variances of the prediction, `observed` (2,) of the estimates.
    """

    residual: FloatArray
    unknown: FloatArray
    observed: FloatArray


class AgreementGate:
    """Compares predicted with observed motion, and says whether predictions may be used.

    Closed at first: odometry has to prove itself. Two medians are watched, which one frame in which
    the filter jumps does not move. That of the residuals, times their number, is how far the
    predictions have drifted off: a velocity that is always wrong shows in it, also while the filter
    is drawn along. That of their sizes shows a motion that is missed and swings to and fro.
    """

    def __init__(self) -> None:
        self._steps: deque[_Step] = deque(maxlen=WINDOW)
        self._calm = 0
        self._open = False
        self._proved_wrong = False

    @property
    def doubt(self) -> Unaided | None:
        """Why predictions may not be used; None if they may."""
        if self._open:
            return None
        return CABLE_DISAGREES if self._proved_wrong else NOT_PROVED

    def interrupt(self) -> None:
        """Note that a frame could not be compared: drift does not add up across it."""
        self._steps.clear()

    def compare(self, residual: FloatArray, unknown: FloatArray, observed: FloatArray) -> None:
        """Take one frame into account.

        Parameters
        ----------
        residual : FloatArray
            Observed minus predicted d and alpha, shape (2,) [px, rad].
        unknown : FloatArray
            Variances of the prediction, shape (2,).
        observed : FloatArray
            Variances of the estimate, shape (2,).
        """
        self._steps.append(_Step(residual, unknown, observed))
        disagreement = self.disagreement()
        if disagreement is None:
            return
        self._calm = self._calm + 1 if disagreement < AGREEMENT else 0
        if disagreement > 1.0:
            self._open, self._proved_wrong = False, True
        elif not self._open and self._calm >= CALM_FRAMES:
            self._open, self._proved_wrong = True, False

    def disagreement(self) -> float | None:
        """Return by how much the predictions are off, 1 at the limit; None: not known."""
        count = len(self._steps)
        if count < FEWEST:
            return None
        residuals = np.array([step.residual for step in self._steps])
        unknown = np.array([step.unknown for step in self._steps])
        ends = self._steps[0].observed + self._steps[-1].observed
        drift = count * np.abs(np.median(residuals, axis=0)) / np.sqrt(unknown.sum(axis=0) + ends)
        step = np.median(np.abs(residuals) / np.sqrt(unknown), axis=0)
        return float(max(drift.max() / LARGEST_DRIFT, step.max() / LARGEST_STEP))
