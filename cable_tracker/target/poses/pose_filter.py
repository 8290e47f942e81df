"""The filter of the preset `default`: particles are poses, weighed by learnt appearance.

Every frame, particles are drawn from a mixture: about those of the frame before, about peaks of
the map of log-ratios, and where a target may come into view. Their weight is the density of the
predicted belief over that of the whole mixture, times the likelihood of their region.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.particle_filter.particles import (
    Particles,
    effective_sample_size,
    log_sum_exp,
    weighted_covariance,
    weighted_mean,
)
from cable_tracker.target.filter_interface import TargetSummary
from cable_tracker.target.measure.outline import Outline
from cable_tracker.target.measure.region import MeasuredFrame, measure_frame
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.state import LOG_SCALE, STATE_SIZE, X, Y, distances_from
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.frame_sampler import FrameSampler
from cable_tracker.target.poses.known_target import (
    adapted_to_contour,
    contour_histograms,
    learn_target,
    outline_at,
)
from cable_tracker.target.poses.map_peaks import propose_from_map, watch_rivals
from cable_tracker.target.poses.pose_belief import PoseBelief, RivalWatch, predict_density
from cable_tracker.target.poses.presence import (
    MOST_PRESENCE,
    presence_by_likeness,
    presence_by_scores,
)
from cable_tracker.tracking.parameter_table import REFERENCE_RATE

FIRST_SPREAD, FIRST_TURN = 0.05, 0.02
"""Standard deviations about a marked target: position in roots of the area; log scale and angle
[rad]."""

FIRST_RATE_PER_SPREAD = 10.0
"""Standard deviation of the rates of position over that of the position [1/s]."""

CLUSTER = 1.0
"""Particles within this many roots of the area of the best one make the estimate."""

CROWD = 0.4
"""Standard deviation of the cost near another target, in roots of the area."""

GOOD_OVERLAP = 0.6
"""Minimum overlap with the expected shape of a contour that the target is adapted to."""

WHOLE_SIZE = 0.2
"""Log scales this far from the usual one still belong to a target that nothing hides."""

WHOLE_RATE = 3.0
"""Factor on the rate of the usual size while the whole contour is in view, in its usual shape."""


class PoseFilter:
    """Particle filter of poses; see the module. It holds no belief itself.

    Parameters
    ----------
    parameters : TargetParameters
        Parameters of the filter.
    rng : numpy.random.Generator
        The only source of randomness.
    """

    def __init__(self, parameters: TargetParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._rng = rng

    def start(
        self, frame: WorkingFrame, mask: BoolArray, *, is_exact: bool
    ) -> tuple[TargetSummary, PoseBelief]:
        """Learn a target from its pixels in a frame; return the summary and the first belief.

        Raises
        ------
        FrameError
            The mask is too small, or does not stand out from its surroundings.
        """
        parameters = self._parameters
        known, measured = learn_target(frame, mask, parameters, is_exact=is_exact)
        state = known.births.last
        spread = FIRST_SPREAD * known.template.size
        rate = FIRST_RATE_PER_SPREAD * spread
        scales = np.array([spread, spread, FIRST_TURN, FIRST_TURN, rate, rate])
        noise = self._rng.standard_normal((parameters.particle_count, STATE_SIZE))
        belief = PoseBelief(
            particles=Particles.equally_weighted(state + noise * scales),
            estimate=state,
            presence=MOST_PRESENCE,
            known=known,
            rivals=RivalWatch(),
        )
        weights = np.full(parameters.particle_count, 1.0 / parameters.particle_count)
        return estimate_and_adapt(belief, measured, weights, 1.0 / REFERENCE_RATE, parameters)

    def step(
        self,
        belief: PoseBelief,
        frame: WorkingFrame,
        dt: float,
        motion: CameraMotion | None,
        others: FloatArray,
        *,
        counts_for: float,
    ) -> tuple[TargetSummary, PoseBelief]:
        """Follow the target into the next frame; return its summary and the new belief.

        Parameters
        ----------
        belief : PoseBelief
            After the frame before.
        frame : WorkingFrame
            The frame.
        dt : float
            Time since the frame before, in which the target may have moved [s].
        motion : CameraMotion or None
            Motion of the camera since then.
        others : FloatArray
            Poses of the other targets that are claimed, shape (K, 6): they exclude this one.
        counts_for : float
            Time that the frame counts for where something is learnt from it [s]: `dt`, but after a
            pause that of one frame.
        """
        parameters, rng = self._parameters, self._rng
        belief = belief.aged(frame, dt, motion, parameters)
        frame_as_learnt = frame.measured_in(colour=belief.known.is_coloured)
        measured = measure_frame(frame_as_learnt, belief.known.appearance, parameters)
        peaks = propose_from_map(belief, measured, parameters)
        belief = replace(belief, rivals=watch_rivals(belief, measured, peaks, dt))
        prediction = predict_density(belief, frame.shape, dt, parameters, rng)
        sampler = FrameSampler(belief, prediction, measured, dt, parameters)
        drawn = sampler.draw(peaks, rng)
        presence = presence_by_scores(sampler, drawn, rng)
        states = drawn.poses.states
        log_weights = drawn.poses.log_prior - drawn.log_proposal
        log_weights += sampler.sharpness * drawn.own_scores
        log_weights -= crowding_costs(states, others, parameters.sharpness, CROWD * belief.size)
        particles = Particles(states, log_weights - log_sum_exp(log_weights))
        weights = cluster_weights(particles, CLUSTER * belief.size)
        estimate = weighted_mean(particles.states, weights)
        belief = replace(belief, particles=particles, estimate=estimate, presence=presence)
        summary, belief = estimate_and_adapt(belief, measured, weights, counts_for, parameters)
        return summary, _with_followed_size(
            belief, counts_for, parameters, is_whole=summary.is_whole
        )


def crowding_costs(states: FloatArray, others: FloatArray, cost: float, reach: float) -> FloatArray:
    """Return the costs of poses (N, 6) near other targets (K, 6), shape (N,), in log-likelihood.

    Parameters
    ----------
    states, others : FloatArray
        Poses.
    cost : float
        Cost at the position of another target, in log-likelihood.
    reach : float
        Standard deviation of the cost over the distance [px].
    """
    if len(others) == 0:
        return np.zeros(len(states))
    gaps = states[:, None, :2] - others[None, :, :2]
    near_others = np.exp(-0.5 * (gaps**2).sum(axis=2) / reach**2)
    costs: FloatArray = cost * near_others.sum(axis=1)
    return costs


def cluster_weights(particles: Particles, reach: float) -> FloatArray:
    """Return the weights of particles, but 0 farther than `reach` [px] from the best one, (N,).

    They sum to one.
    """
    weights, states = particles.weights, particles.states
    best = states[int(np.argmax(weights))]
    chosen = np.where(distances_from(best[X], best[Y], states) <= reach, weights, 0.0)
    shares: FloatArray = chosen / chosen.sum()
    return shares


def estimate_and_adapt(
    belief: PoseBelief,
    measured: MeasuredFrame,
    weights: FloatArray,
    dt: float,
    parameters: TargetParameters,
) -> tuple[TargetSummary, PoseBelief]:
    """Find the outline, adapt the known target to it, and return summary and belief.

    Parameters
    ----------
    belief : PoseBelief
        Belief with particles and estimate of the frame.
    weights : FloatArray
        Weights of the particles that make the estimate, shape (N,).
    dt : float
        Time that the frame counts for [s].
    """
    known, frame = belief.known, measured.frame
    outline = outline_at(belief.estimate, measured.ratios, frame, known, parameters)
    shown = contour_histograms(outline, measured, known, parameters)
    presence = presence_by_likeness(belief, shown, parameters, is_coloured=frame.is_coloured)
    covariance = weighted_covariance(belief.particles.states, weights, belief.estimate)
    sigma = math.sqrt(max(covariance[X, X], covariance[Y, Y]))
    is_near = sigma <= parameters.converged_position * belief.size
    is_whole = _is_whole(outline, frame.shape)
    is_sure = presence >= parameters.presence_to_track and is_near
    score = float(measured.scores(belief.estimate[None], known.template)[0])
    if is_sure:
        known = known.with_last_pose(belief.estimate)
        gap = belief.estimate[LOG_SCALE] - known.usual_log_scale
        if is_whole and abs(gap) < WHOLE_SIZE and outline is not None and shown is not None:
            known = adapted_to_contour(
                known, outline, shown, parameters, dt=dt, angle=belief.angle, score=score
            )
    summary = TargetSummary(
        state=belief.estimate.copy(),
        covariance=covariance,
        outline=outline,
        is_whole=is_whole and not known.template.is_bar,
        presence=presence,
        effective_sample_size=effective_sample_size(belief.particles.log_weights),
        score=score,
        supports_claim=is_sure,
        supports_keeping=presence >= parameters.presence_to_lose and is_near,
    )
    return summary, replace(belief, presence=presence, known=known)


def _is_whole(outline: Outline | None, shape: tuple[int, int]) -> bool:
    """Return whether a contour has the expected shape, and lies inside the picture."""
    return (
        outline is not None
        and outline.overlap >= GOOD_OVERLAP
        and not outline.touches_border(shape)
    )


def _with_followed_size(
    belief: PoseBelief, dt: float, parameters: TargetParameters, *, is_whole: bool
) -> PoseBelief:
    """Let the usual size follow while the target is surely in view."""
    if belief.presence < parameters.presence_to_track:
        return belief
    factor = WHOLE_RATE if is_whole else 1.0
    share = 1.0 - math.exp(-dt * factor / parameters.size_time)
    return replace(belief, known=belief.known.with_size(belief.estimate, share))
