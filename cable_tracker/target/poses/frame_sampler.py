"""Draws the particles of a frame, with the densities and scores for their weights."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.compilation import compiled
from cable_tracker.particle_filter.particles import systematic_resampling
from cable_tracker.particle_filter.student_t import (
    KernelMixture,
    kernel_mixture,
    standard_student_t,
)
from cable_tracker.target.measure.region import MeasuredFrame
from cable_tracker.target.model.predicted_density import PredictedDensity, kernels_of, log_mix
from cable_tracker.target.model.state import (
    ANGLE,
    POSE_SIZE,
    at_rest,
    distances_from,
    wrap_full_turn,
)
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.map_peaks import PeakPoses
from cable_tracker.target.poses.pose_belief import RIVAL_SCORE, PoseBelief
from cable_tracker.tracking.rates import share_over_time

PEAK_SPREAD = (0.25, 0.15, 0.12)
"""Scales of the kernels about peaks: position in roots of the area, log scale, angle [rad]."""

REFINED_SPREAD = (0.06, 0.05, 0.06)
"""Scales of the kernels about the best particles of the frame, in the same units."""

REFINED = 5
"""Number of best-scoring particles that refinement kernels are centred on."""

DRAWN_TAIL = 4.0
"""Degrees of freedom of the kernels about peaks and best particles."""

ELSEWHERE_MARGIN = 0.3
"""Gap of scores elsewhere below the best one here, while the target is observed here."""

OWN_REACH = 0.8
"""Largest distance of the target's own place from the expected one, in roots of the area."""


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """One part of the mixture that particles are drawn from.

    Attributes
    ----------
    kernels : KernelMixture
        Kernels over poses.
    weights : FloatArray
        Weights of the kernels, summing to one.
    share : float
        Share of the particles that come from this part.
    """

    kernels: KernelMixture
    weights: FloatArray
    share: float

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw poses, shape (count, 4)."""
        if count == 0:
            return np.empty((0, POSE_SIZE))
        chosen = systematic_resampling(self.weights, count, rng)
        noise = standard_student_t(rng, count, POSE_SIZE, self.kernels.degrees_of_freedom)
        poses: FloatArray = self.kernels.places[chosen] + noise * self.kernels.scales
        return poses

    def log_density(self, poses: FloatArray) -> FloatArray:
        """Return the log of its share of the whole mixture's density at poses (N, 4)."""
        kernels = kernels_of(poses, self.kernels)
        return math.log(self.share) + log_mix(kernels, self.weights, self.kernels)


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
        return replace(self, score_penalty=max(best - here, 0.0) + ELSEWHERE_MARGIN)

    def own_scores(self, states: FloatArray, scores: FloatArray) -> FloatArray:
        """Return the scores (N,) of poses (N, 6), less the penalty elsewhere, shape (N,)."""
        if self.score_penalty == 0.0:
            return scores
        return scores - self.score_penalty * self.is_elsewhere(states)


class ProposalCounts(NamedTuple):
    """Numbers of particles that are drawn from each part of the proposal.

    Attributes
    ----------
    followed : int
        Number drawn about particles of the frame before.
    peaks : int
        Number drawn about peaks of the map of log-ratios.
    search : int
        Number drawn where a target may come into view.
    refined : int
        Number drawn about the best of all these.
    """

    followed: int
    peaks: int
    search: int
    refined: int


def proposal_counts(parameters: TargetParameters, *, has_peaks: bool) -> ProposalCounts:
    """Divide the particles among the parts of the proposal."""
    refined = round(parameters.refinement_share * parameters.particle_count)
    search = round(parameters.search_share * parameters.particle_count)
    peaks = round(parameters.place_share * parameters.particle_count) if has_peaks else 0
    followed = parameters.particle_count - peaks - search - refined
    if followed < 1:  # Of a handful, all follow.
        return ProposalCounts(parameters.particle_count, 0, 0, 0)
    return ProposalCounts(followed, peaks, search, refined)


class ScoredPoses(NamedTuple):
    """Poses with the densities of the belief and their scores; a row for each in every array.

    Attributes
    ----------
    states : FloatArray
        Shape (N, 6).
    log_prior : FloatArray
        Log-density of the prediction, sizes included, shape (N,).
    log_birth : FloatArray
        Log-density of the births, shape (N,).
    kernel_values : FloatArray
        Kernels of the prediction over their peak, shape (N, M).
    scores : FloatArray
        Scores of their regions, shape (N,).
    """

    states: FloatArray
    log_prior: FloatArray
    log_birth: FloatArray
    kernel_values: FloatArray
    scores: FloatArray


class DrawnParticles(NamedTuple):
    """The particles of a frame before they are weighed.

    Attributes
    ----------
    poses : ScoredPoses
        The particles, with their rates.
    log_proposal : FloatArray
        Log-density of the proposal that they were drawn from, shape (N,).
    own_scores : FloatArray
        Scores less the penalty where another target is seen, shape (N,).
    """

    poses: ScoredPoses
    log_proposal: FloatArray
    own_scores: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class FrameSampler:
    """Draws the particles of one frame.

    Attributes
    ----------
    belief : PoseBelief
        Belief after the frame before, carried on to this one.
    prediction : PredictedDensity
        Predicted density of the poses in this frame.
    measured : MeasuredFrame
        The frame.
    dt : float
        Time since the frame before [s].
    parameters : TargetParameters
        The tracker's parameters.
    """

    belief: PoseBelief
    prediction: PredictedDensity
    measured: MeasuredFrame
    dt: float
    parameters: TargetParameters

    @property
    def sharpness(self) -> float:
        """Weight of the score in the likelihood."""
        return self.parameters.sharpness * self.belief.rivals.sharpness_factor

    def draw(self, peaks: PeakPoses, rng: np.random.Generator) -> DrawnParticles:
        """Draw the particles, with the densities of belief and proposal at each."""
        counts = proposal_counts(self.parameters, has_peaks=len(peaks.poses) > 0)
        prediction = self.prediction
        ancestors = len(prediction.alive)
        even = np.full(ancestors, 1.0 / ancestors)
        followed = Proposal(
            prediction.kernels, even, counts.followed / self.parameters.particle_count
        )
        others = []
        parts = [followed.draw(counts.followed, rng)]
        if counts.peaks:
            weights = peaks.strengths / peaks.strengths.sum()
            others.append(self._about(peaks.poses, weights, PEAK_SPREAD, counts.peaks))
            parts.append(others[-1].draw(counts.peaks, rng))
        parts.append(prediction.births.draw(counts.search, prediction.memory_share, rng))
        scored = self._scored(np.concatenate(parts))
        own = self._expected_place(scored)
        if counts.refined:
            best = self._best(scored, own)
            even = np.full(len(best), 1.0 / len(best))
            others.append(self._about(best, even, REFINED_SPREAD, counts.refined))
            more = self._scored(others[-1].draw(counts.refined, rng))
            scored = ScoredPoses(*(np.concatenate(pair) for pair in zip(scored, more, strict=True)))
        log_proposal = self._log_proposal(scored, followed, others, counts)
        self._set_rates(scored, rng)
        own_scores = own.own_scores(scored.states, scored.scores)
        return DrawnParticles(scored, log_proposal, own_scores)

    def _about(
        self,
        poses: FloatArray,
        weights: FloatArray,
        spread: tuple[float, float, float],
        count: int,
    ) -> Proposal:
        """Return the proposal of `count` particles about poses (K, 4) with weights (K,)."""
        size = self.belief.size
        scales = np.array([spread[0] * size, spread[0] * size, spread[1], spread[2]])
        kernels = kernel_mixture(poses, scales, DRAWN_TAIL, weights)
        return Proposal(kernels, weights, count / self.parameters.particle_count)

    def _scored(self, poses: FloatArray) -> ScoredPoses:
        """Return poses (N, 4) at rest, with the densities of the belief and their scores."""
        known, reference = self.belief.known, self.belief.angle
        states = at_rest(poses)
        angles = states[:, ANGLE]
        states[:, ANGLE] = reference + wrap_full_turn(angles - reference)
        log_prior, log_birth, kernel_values = self.prediction.log_density(states)
        log_prior = log_prior + known.log_size_factor(states, self.parameters.size_spread)
        scores = self.measured.scores(states, known.template)
        return ScoredPoses(states, log_prior, log_birth, kernel_values, scores)

    def _expected_place(self, scored: ScoredPoses) -> ExpectedPlace:
        """Return the expected place of the target, with the penalty on scores elsewhere."""
        belief = self.belief
        x, y = belief.estimate[:2] + belief.estimate[POSE_SIZE:] * self.dt
        place = ExpectedPlace(float(x), float(y), OWN_REACH * belief.size)
        if belief.presence < self.parameters.presence_to_track:
            return place
        return place.with_penalty(
            scored.states, scored.scores, RIVAL_SCORE * belief.known.usual.mean
        )

    def _best(self, scored: ScoredPoses, own: ExpectedPlace) -> FloatArray:
        """Return the best of the poses that have been drawn, shape (K, 4)."""
        scores = own.own_scores(scored.states, scored.scores)
        worth = scored.log_prior + self.sharpness * scores
        best: FloatArray = scored.states[np.argsort(-worth)[:REFINED], :POSE_SIZE]
        return best

    def _log_proposal(
        self,
        scored: ScoredPoses,
        followed: Proposal,
        others: list[Proposal],
        counts: ProposalCounts,
    ) -> FloatArray:
        """Return the log-density of the whole mixture at each pose, shape (N,)."""
        following = log_mix(scored.kernel_values, followed.weights, followed.kernels)
        parts = [following + math.log(followed.share)]
        parts += [part.log_density(scored.states[:, :POSE_SIZE]) for part in others]
        if counts.search:
            parts.append(
                math.log(counts.search / self.parameters.particle_count) + scored.log_birth
            )
        log_proposal: FloatArray = np.logaddexp.reduce(parts)
        return log_proposal

    def _set_rates(self, scored: ScoredPoses, rng: np.random.Generator) -> None:
        """Set the rates of every pose: those of an ancestor drawn for it, corrected by a gain."""
        states = scored.states
        parents = choose_columns(scored.kernel_values, rng.random(len(states)))
        unforeseen = states[:, :2] - self.prediction.kernels.places[parents, :2]
        # A jump that no movement explains says nothing about the rates.
        limit = 0.5 * self.belief.size
        reach = np.hypot(unforeseen[:, 0], unforeseen[:, 1])
        # Rates fade by their damping over time, so they must be learnt over time as well.
        share = share_over_time(self.parameters.rate_gain, self.dt)
        gain = share * np.where(reach > limit, 0.0, 1.0)
        gain *= self.belief.rivals.gain_factor
        states[:, POSE_SIZE:] = (
            self.prediction.rates[parents] + gain[:, None] * unforeseen / self.dt
        )


@compiled
def choose_columns(values: FloatArray, shares: FloatArray) -> NDArray[np.int64]:
    """Draw a column of each row (N, M) by its values, from uniform numbers (N,), shape (N,)."""
    chosen = np.empty(len(values), np.int64)
    for row in range(len(values)):
        total = 0.0
        for column in range(values.shape[1]):
            total += values[row, column]
        rest = shares[row] * total
        chosen[row] = values.shape[1] - 1
        for column in range(values.shape[1]):
            rest -= values[row, column]
            if rest < 0.0:
                chosen[row] = column
                break
    return chosen
