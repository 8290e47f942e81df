"""See `cable_tracker.cable.hypotheses.multi_hypothesis_filter`.

The same random numbers are drawn in the same order, and the same particles come out, to rounding.
"""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.compiled.clusters import leading_covariance
from cable_tracker.cable.compiled.conclusion import conclude
from cable_tracker.cable.compiled.likelihood_ratio import CompiledLikelihoodRatio
from cable_tracker.cable.compiled.mixture_sample import Balance
from cable_tracker.cable.compiled.prediction import Step, ancestor_groups, survivors_of
from cable_tracker.cable.compiled.prior_density import prior_arrays
from cable_tracker.cable.compiled.rounds import Frame, Plan, Rules, draw_sample, empty_sample
from cable_tracker.cable.hypotheses.belief import Belief
from cable_tracker.cable.hypotheses.clusters import Cluster
from cable_tracker.cable.hypotheses.leaving import survival_rates
from cable_tracker.cable.hypotheses.multi_hypothesis_filter import (
    DETECTION_SIGMAS,
    LEAST_PRESENCE,
    MOST_PRESENCE,
    MOST_REFINED,
    SMALLEST_REFINED,
    SMALLEST_SIGMAS,
    MultiHypothesisFilter,
    Survivors,
    annealing_power,
    widening_in,
)
from cable_tracker.cable.hypotheses.prior_density import Prior
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.movement import rate_damping_over, state_limits
from cable_tracker.cable.model.state import STATE_SIZE
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.compiled.weights import effective_sample_size
from cable_tracker.particle_filter.existence import update_existence
from cable_tracker.particle_filter.particles import Particles

NO_ANCHOR = np.empty((0, STATE_SIZE))


class CompiledMultiHypothesisFilter(MultiHypothesisFilter):
    """The twin of `MultiHypothesisFilter`."""

    def __init__(
        self,
        parameters: TrackerParameters,
        observation: CompiledLikelihoodRatio,
        image_size: tuple[int, int],
        rng: np.random.Generator,
    ) -> None:
        super().__init__(parameters, observation, image_size, rng)
        self._ratios = observation
        limits = state_limits(parameters, image_size[0])
        self._balance = Balance(
            parameters.evidence_of_bottom, parameters.evidence_limit, parameters.evidence_repeated
        )
        rounds = parameters.refinement_rounds
        self._rules = Rules(
            image_width=float(image_size[0]),
            degrees_of_freedom=self._movement.degrees_of_freedom,
            lower=limits.lower,
            upper=limits.upper,
            detection_sigmas=DETECTION_SIGMAS * self._unit,
            smallest_sigmas=SMALLEST_SIGMAS * self._unit,
            powers=np.array([annealing_power(number, rounds) for number in range(rounds)]),
            widenings=np.array([widening_in(number) for number in range(rounds)]),
            most_refined=MOST_REFINED,
            smallest_refined=SMALLEST_REFINED,
        )
        self._counts = np.array(self._refined, np.int64)
        self._room = empty_sample(parameters.particle_count)

    def step(
        self, belief: Belief, image: WorkingImage, dt: float, detections: FloatArray
    ) -> Belief:
        """Return the belief after one more frame; see the twin."""
        prior = self._predict(belief, dt)
        shares = self._shares(prior.existence, len(detections))
        frame = Frame(
            prior=prior_arrays(prior),
            noise=self._noise(shares),
            look=self._ratios.look(image),
            bright=belief.bright,
            reference_angle=prior.reference_angle,
            ancestors=self._resample(prior.proposal, shares.survivors, self._rng),
            detected=detections,
        )
        plan = Plan(
            shares.survivors,
            shares.births,
            prior.births.remembered_of(shares.births),
            shares.detections,
            self._counts,
        )
        filled = draw_sample(self._room, frame, plan, self._rules)
        return self._conclude_sample(belief, prior, filled, dt)

    def leading_covariance(self, belief: Belief) -> FloatArray:
        """Return the covariance (8, 8) of the leading cluster, in the chart about its mean."""
        leader, particles = belief.clusters[0], belief.particles
        return leading_covariance(
            particles.states, particles.log_weights, leader.members, leader.mass, leader.mean
        )

    def effective_sample_size(self, belief: Belief) -> float:
        """Return N_eff of all particles."""
        return effective_sample_size(belief.particles.log_weights)

    def _survivors(self, belief: Belief, dt: float) -> Survivors:
        if self._parameters.resampling != "systematic" or self._movement.is_aided:
            return super()._survivors(belief, dt)
        particles = belief.particles
        count = min(self._parameters.ancestor_count, particles.count)
        members = np.array([cluster.members for cluster in belief.clusters])
        groups = ancestor_groups(members, particles.log_weights, count)
        offsets = self._rng.random(len(groups.counts))
        step = self._step_over(dt, belief.reference_angle)
        return Survivors(*survivors_of(particles.states, groups, offsets, step))

    def _step_over(self, dt: float, reference_angle: float) -> Step:
        parameters = self._parameters
        width, height = self._image_size
        return Step(
            reference_angle=reference_angle,
            size=(float(width), float(height)),
            rates=survival_rates(parameters, width),
            dt=dt,
            effective_time=self._movement.effective_time(dt),
            damping=rate_damping_over(parameters, dt),
        )

    def _conclude_sample(self, before: Belief, prior: Prior, filled: int, dt: float) -> Belief:
        anchor = self._anchor(before, prior)
        anchors = NO_ANCHOR if anchor is None else anchor[None, :]
        width = self._rules.image_width
        found = conclude(self._room, filled, width, anchors, self._balance, before.bright)
        if not len(found.masses):
            return self._spread(before, prior)
        presence = update_existence(
            prior.existence, found.log_evidence, LEAST_PRESENCE, MOST_PRESENCE
        )
        clusters = tuple(map(Cluster, found.masses.tolist(), found.means, found.members))
        return self._belief_of(
            before,
            prior,
            dt,
            Particles(found.states, found.log_weights),
            clusters,
            presence=presence,
            clearness=found.clearness,
            seen=found.seen,
            brightness=found.brightness,
        )
