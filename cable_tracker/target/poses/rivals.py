"""Rivals: other objects that resemble the target.

Two of a kind never score the same, and the better one would take the target over within a few
frames, however far away it is. While the target is observed where it is expected, the other one
must be something else, so its score is no evidence about the target. Near each other they may be
told apart by their motion: two that cross keep their rates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.target.model.state import distances_from

MARGIN = 0.3
"""Gap of scores elsewhere below the best one here, while the target is observed here."""

RIVAL_SCORE = 0.75
"""Another peak whose region scores at least this share of the target's usual score is like it."""

RIVAL_NEAR, RIVAL_FAR, RIVAL_TOUCHES = 1.2, 2.6, 1.9
"""Range of distances of a rival that is watched, and distance below which one that is not seen any
more has merged with the target, in roots of the area."""

RIVAL_FRAMES = 5
"""Consecutive frames in which both must be observed; a jump of the estimate mimics a rival for one
frame."""

RIVAL_TIME = 1.2
"""Time after a rival was last observed for which it counts as merged with the target [s]."""

HELD_GAIN = 0.15
"""Factor on the gain of the rates while a rival is near."""

MERGED_SHARPNESS = 0.01
"""Factor on the weight of the score while two are merged: it is best in the middle of both."""

MERGED_JUMPS = 0.1
"""Factor on the share of jumps while two are merged: each of them goes on as it went."""


@dataclass(frozen=True, slots=True)
class RivalWatch:
    """When a rival was near the target.

    Attributes
    ----------
    since : float
        Time since both were observed [s]; infinite: never, or it went away again.
    frames : int
        Consecutive frames in which both have been observed.
    """

    since: float = math.inf
    frames: int = 0

    def aged(self, dt: float) -> RivalWatch:
        """Return the watch `dt` seconds later."""
        return replace(self, since=self.since + dt)

    def after(self, distances: FloatArray) -> RivalWatch:
        """Return the watch after the peaks of a frame.

        Parameters
        ----------
        distances : FloatArray
            Distances of peaks that resemble the target from its last place, in roots of its
            area, shape (K,).
        """
        if not are_beside(distances):
            return replace(self, frames=0)
        if self.frames + 1 < RIVAL_FRAMES:
            return replace(self, frames=self.frames + 1)
        touches = float(distances[_is_beside(distances)].min()) < RIVAL_TOUCHES
        # One that is last seen farther away has not merged with the target.
        return RivalWatch(0.0 if touches else math.inf, self.frames + 1)

    @property
    def is_near(self) -> bool:
        """Whether a rival is near, or was a moment ago."""
        return self.since <= RIVAL_TIME

    @property
    def is_merged(self) -> bool:
        """Whether target and rival are taken for one."""
        return 0.0 < self.since <= RIVAL_TIME

    @property
    def gain_factor(self) -> float:
        """Share of the usual gain of the rates."""
        if self.is_merged:
            return 0.0
        return HELD_GAIN if self.is_near else 1.0

    @property
    def sharpness_factor(self) -> float:
        """Share of the usual weight of the score."""
        return MERGED_SHARPNESS if self.is_merged else 1.0

    @property
    def jump_factor(self) -> float:
        """Share of the usual share of jumps."""
        return MERGED_JUMPS if self.is_merged else 1.0


def are_beside(distances: FloatArray) -> bool:
    """Return whether one peak is at the target's place, and another beside it.

    The target itself must be observed at its place: else the peak beside it may be the target.
    """
    return bool(_is_beside(distances).any() and (distances <= RIVAL_NEAR).any())


def _is_beside(distances: FloatArray) -> BoolArray:
    beside: BoolArray = (distances > RIVAL_NEAR) & (distances < RIVAL_FAR)
    return beside


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
        Reduction of the scores of poses elsewhere; 0 unless the target is observed here.
    """

    x: float
    y: float
    reach: float
    score_penalty: float = 0.0

    def is_elsewhere(self, states: FloatArray) -> BoolArray:
        """Return which poses (N, 6) are beyond the reach of this place, shape (N,)."""
        elsewhere: BoolArray = distances_from(self.x, self.y, states) > self.reach
        return elsewhere

    def with_penalty(self, states: FloatArray, scores: FloatArray, least: float) -> ExpectedPlace:
        """Return the place with the penalty that the scores of a frame call for.

        Parameters
        ----------
        states : FloatArray
            Poses in the frame, shape (N, 6).
        scores : FloatArray
            Scores of their regions, shape (N,).
        least : float
            Score from which on the target counts as observed here.
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
