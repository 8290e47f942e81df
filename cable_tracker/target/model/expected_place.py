"""Where the target is expected: what looks like it elsewhere is another one.

Two of a kind never score the same, and the better one would take the target over within a few
frames, however far away it is. While the target is seen where it is expected, the other one must be
something else, so its score says nothing about the target.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.target.model.state import distances_from

MARGIN = 0.3
"""Gap by which scores elsewhere stay below the best score here, while the target is seen here."""


@dataclass(frozen=True, slots=True, eq=False)
class ExpectedPlace:
    """The expected place of the target.

    Attributes
    ----------
    x, y : float
        From the image centre, y up [px].
    reach : float
        Distance from the expected place beyond which a pose is elsewhere [px].
    score_penalty : float
        Reduction of the scores of poses elsewhere; 0 unless the target is seen here.
    """

    x: float
    y: float
    reach: float
    score_penalty: float = 0.0

    def is_elsewhere(self, states: FloatArray) -> BoolArray:
        """Tell which poses (N, 6) are not here, shape (N,)."""
        elsewhere: BoolArray = distances_from(self.x, self.y, states) > self.reach
        return elsewhere

    def seen(self, states: FloatArray, scores: FloatArray, least: float) -> ExpectedPlace:
        """Return it with the penalty that follows from a frame.

        Parameters
        ----------
        states : FloatArray
            Poses in the frame, shape (N, 6).
        scores : FloatArray
            Scores of their regions, shape (N,).
        least : float
            Score from which on the target is seen here.
        """
        elsewhere = self.is_elsewhere(states)
        here = float(scores[~elsewhere].max(initial=-np.inf))
        if here < least:
            return self
        best = float(scores[elsewhere].max(initial=here))
        return replace(self, score_penalty=max(best - here, 0.0) + MARGIN)

    def own_scores(self, states: FloatArray, scores: FloatArray) -> FloatArray:
        """Return the scores (N,) of poses (N, 6), less the penalty elsewhere, shape (N,)."""
        if self.score_penalty == 0.0:
            return scores
        return scores - self.score_penalty * self.is_elsewhere(states)
