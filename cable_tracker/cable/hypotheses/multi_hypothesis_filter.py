"""The particle filter of this project: several hypotheses, and whether there is a cable at all.

Per frame, the particles stand for the density

    f(x) = P(survived) (sum_j W_j K(x | x_j) + r J(x)) + P(born) b(x)

of a cable in view, where K is the movement with its heavy tails about the particles x_j of the
frame before, J the density of cables that share one border with the leading hypothesis, seldom (r)
the right one, and b that of cables that come into view. They are not drawn from f alone but
from a mixture of proposals: from f, about what a detector sees, and, in rounds, about the best
particles of the same frame. A particle weighs f(x) L(x) / q(x), where q is the density of the whole
mixture and L the likelihood ratio of the frame: no proposal is a second prior, wherever it comes
from. Whether a hypothesis is a cable at all is judged against strips drawn at random in the same
frame, see `presence`.

References
----------
M. Klaas, N. de Freitas and A. Doucet (2005), "Toward practical N^2 Monte Carlo: the marginal
particle filter": weights by the density of the whole mixture.
O. Cappe, A. Guillin, J.-M. Marin and C. Robert (2004), "Population Monte Carlo": the rounds.
B. Ristic et al. (2013), "A tutorial on Bernoulli filters": the probability of existence.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cable_tracker.arrays import FloatArray, IndexArray
from cable_tracker.cable.filter_interface import (
    BeliefSummary,
    CableFilter,
    ParticleBelief,
    resampled_states,
)
from cable_tracker.cable.hypotheses.ancestors import (
    Ancestors,
    draw_ancestors,
    survival_rates,
    surviving_ancestors,
)
from cable_tracker.cable.hypotheses.association import is_same_hypothesis
from cable_tracker.cable.hypotheses.belief import Belief, initial_belief, resampled_belief
from cable_tracker.cable.hypotheses.births import BirthDensity, birth_density_of, draw_births
from cable_tracker.cable.hypotheses.border_displacement import displaced_covariance
from cable_tracker.cable.hypotheses.border_jump import BORDER_ERROR_RATE, BorderJump, jump_from
from cable_tracker.cable.hypotheses.clusters import Clusters
from cable_tracker.cable.hypotheses.conclusion import Conclusion, Hypotheses, draw_and_conclude
from cable_tracker.cable.hypotheses.frame_noise import FrameNoise, draw_frame_noise
from cable_tracker.cable.hypotheses.polarity import updated_p_bright
from cable_tracker.cable.hypotheses.predicted_density import LEAST_PROBABILITY, PredictedDensity
from cable_tracker.cable.hypotheses.presence import PriorPresence, gain_over
from cable_tracker.cable.hypotheses.proposal_config import (
    ProposalConfig,
    beside_a_known_cable,
    proposal_config,
)
from cable_tracker.cable.hypotheses.proposals import ProposalInputs
from cable_tracker.cable.hypotheses.remembered_cable import remember
from cable_tracker.cable.hypotheses.rounds import refined_counts
from cable_tracker.cable.hypotheses.sample import empty_sample
from cable_tracker.cable.hypotheses.sample_counts import SampleCounts, sample_counts
from cable_tracker.cable.hypotheses.thin_strips import needed_clearness
from cable_tracker.cable.hypotheses.width_prior import updated_width_prior
from cable_tracker.cable.measure.border_points import MINIMUM_POINTS, frame_scan
from cable_tracker.cable.measure.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.polarity_prior import polarity_prior
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.estimate import Hypothesis
from cable_tracker.cable.model.geometry import wrap_state
from cable_tracker.cable.model.initial_state import search_box
from cable_tracker.cable.model.motion_aid import MotionAid
from cable_tracker.cable.model.movement import CableMovement
from cable_tracker.cable.model.state import (
    POSE_SIZE,
    STATE_SIZE,
    CableState,
    StateColumn,
    pose_units,
)
from cable_tracker.cable.model.statistics import wrapped_estimate
from cable_tracker.cable.parameters.parameters import REFERENCE_RATE, TrackerParameters
from cable_tracker.particle_filter.existence import (
    PredictedExistence,
    predict_existence,
    probability_of,
)
from cable_tracker.particle_filter.kernel_mixture import kernel_mixture
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import RESAMPLING_SCHEMES
from cable_tracker.tracking.rates import event_probability

GIVEN_PRESENCE = 0.95
"""Probability of a cable at the place that an operator or planner gave."""

LEAST_PRESENCE = 1e-3
"""Probability that there is a cable before any frame has been seen."""

KNOWN_PRESENCE = 0.5
"""A hypothesis is held for a cable while its presence is above this."""

MEMORY_PRESENCE, MEMORY_MASS = 0.9, 0.7
"""Minimum presence and minimum mass of the leading cluster for updating memory and width prior."""

SMALLEST_KERNEL = np.array([0.05, np.deg2rad(0.02), 0.05, np.deg2rad(0.02)])
"""Lower bound of the kernel scales [px at the reference width, rad]: a scale of zero has no
density."""

SMALLEST_HYPOTHESIS = 0.01
"""Minimum mass of a cluster that is reported; the leading one always is."""

NO_ANCHOR = np.empty((0, STATE_SIZE))


class MultiHypothesisFilter(CableFilter[Belief]):
    """See the module.

    Parameters
    ----------
    parameters : TrackerParameters
        The tracker's parameters.
    observation : BorderLikelihoodRatio
        The likelihood ratio of a frame.
    image_size : (int, int)
        Width and height of the frames [px].
    rng : numpy.random.Generator
        The only source of randomness.
    """

    def __init__(
        self,
        parameters: TrackerParameters,
        observation: BorderLikelihoodRatio,
        image_size: tuple[int, int],
        rng: np.random.Generator,
    ) -> None:
        width = image_size[0]
        self._parameters = parameters
        self._observation = observation
        self._image_size = image_size
        self._rng = rng
        self._resample = RESAMPLING_SCHEMES[parameters.resampling]
        self._movement = CableMovement(parameters, width)
        self._box = search_box(parameters, width)
        self._survival_rates = survival_rates(parameters, width)
        self._smallest_kernel = SMALLEST_KERNEL * pose_units(width)
        self._refined = refined_counts(parameters)
        self._config = proposal_config(parameters, self._movement.degrees_of_freedom, image_size)
        self._known_config = beside_a_known_cable(self._config, parameters)
        self._sample = empty_sample(parameters.particle_count)

    def first_belief(self) -> Belief:
        """Return the belief of a search: the prior, without a history."""
        states = self._box.draw(self._parameters.particle_count, self._rng)
        return initial_belief(states, LEAST_PRESENCE)

    def given_belief(self, states: FloatArray) -> Belief:
        """Return the belief after states (N, 8) of the cable were given."""
        return replace(self.guessed_belief(states), known_time=math.inf)

    def guessed_belief(self, states: FloatArray) -> Belief:
        """Return the belief after states (N, 8) were given that may be of something else."""
        return initial_belief(states, GIVEN_PRESENCE)

    def converted(self, belief: ParticleBelief) -> Belief:
        """Return the belief of any filter as this one's, with as many particles as wanted."""
        if not isinstance(belief, Belief):
            states = resampled_states(belief, self._parameters, self._rng)
            return self.guessed_belief(states)
        count = self._parameters.particle_count
        if belief.particles.count == count:
            return belief
        indices = self._resample(belief.particles.weights, count, self._rng)
        return resampled_belief(belief, indices)

    def is_searching(self, belief: Belief) -> bool:
        """Tell whether the presence says so."""
        return belief.presence < KNOWN_PRESENCE

    def step(
        self,
        belief: Belief,
        image: WorkingImage,
        dt: float,
        detections: FloatArray,
        motion: MotionAid | None = None,
    ) -> Belief:
        """Return the belief after one more frame; the arguments are those of `CableFilter.step`."""
        if belief.refused_time >= self._parameters.search_time:
            belief = self._forgotten_belief(belief)
        belief = belief.aged(dt)
        births = birth_density_of(
            self._box, belief.memory, self._parameters.memory_time, self._image_size
        )
        expected = self._expected(belief, dt, motion)
        expected_leader = expected[0]
        predicted, existence = self._predict(belief, births, expected_leader, dt, motion)
        counts = sample_counts(self._parameters, existence, births, len(detections), self._refined)
        noise = self._draw_noise(counts)
        inputs = ProposalInputs(
            predicted=predicted,
            noise=noise,
            scan=frame_scan(image),
            model=self._observation.model_for(image),
            polarity=polarity_prior(belief.p_bright),
            reference_angle=belief.reference_angle,
            ancestors=self._draw_surviving(predicted, counts),
            detected=detections,
            anchors=NO_ANCHOR if self.is_searching(belief) else expected[:1],
        )
        prior = self._prior_presence(belief, expected, existence, dt)
        found = draw_and_conclude(self._sample, inputs, counts, self._config_for(belief), prior)
        if not len(found.hypotheses.clusters.masses):
            return self._restarted_belief(belief, births)
        return self._concluded(belief, found, expected_leader, dt)

    def _draw_noise(self, counts: SampleCounts) -> FrameNoise:
        """Draw the random numbers of a frame."""
        degrees_of_freedom = self._movement.degrees_of_freedom
        count = self._parameters.particle_count
        return draw_frame_noise(self._rng, count, counts.births, degrees_of_freedom)

    def _draw_surviving(self, predicted: PredictedDensity, counts: SampleCounts) -> IndexArray:
        """Draw about which ancestors the survivors are drawn, each as often as the others."""
        ancestor_count = len(predicted.rates)
        even = np.full(ancestor_count, 1.0 / ancestor_count)
        return self._resample(even, counts.survivors, self._rng)

    def _config_for(self, belief: Belief) -> ProposalConfig:
        """Return how proposals are made: also by whether the leader is known to be the cable."""
        return self._known_config if self._is_known(belief) else self._config

    def _is_known(self, belief: Belief) -> bool:
        """Tell whether the leader was given, or has been clear enough to claim for long enough."""
        return belief.known_time >= self._parameters.known_after

    def _prior_presence(
        self, belief: Belief, expected: FloatArray, existence: PredictedExistence, dt: float
    ) -> PriorPresence:
        """Return what is known of the hypotheses, expected at (J, 8), before the frame is seen."""
        parameters = self._parameters
        return PriorPresence(
            expected=expected,
            log_odds=belief.log_odds,
            survival=existence.survived / max(belief.presence, LEAST_PROBABILITY),
            appearance=event_probability(parameters.appearance_rate, dt),
            gain=gain_over(parameters.presence_gain, dt),
        )

    def _forgotten_belief(self, belief: Belief) -> Belief:
        """Return the belief without the hypotheses: the leading one can never be claimed."""
        return replace(self.first_belief(), p_bright=belief.p_bright)

    def _predict(
        self,
        belief: Belief,
        births: BirthDensity,
        leader: FloatArray,
        dt: float,
        motion: MotionAid | None,
    ) -> tuple[PredictedDensity, PredictedExistence]:
        """Return the density of cables before the frame is seen, and the probability of one."""
        parameters, width_prior = self._parameters, belief.width_prior
        ancestors, survival = self._draw_ancestors(belief, dt)
        drifted = self._movement.draw_centres(ancestors.states, dt, self._rng, motion)
        # Without movement the kernel would be a point: the first frame after a given prior.
        sigmas = self._movement.diffusion_sigmas(max(dt, 1.0 / REFERENCE_RATE), motion)
        birth = event_probability(parameters.appearance_rate, dt)
        existence = predict_existence(belief.presence, survival, birth)
        predicted = PredictedDensity(
            kernels=kernel_mixture(
                np.ascontiguousarray(drifted[:, :POSE_SIZE]),
                np.maximum(sigmas[:POSE_SIZE], self._smallest_kernel),
                self._movement.degrees_of_freedom,
                ancestors.weights,
            ),
            rates=np.ascontiguousarray(drifted[:, POSE_SIZE:]),
            rate_sigmas=np.ascontiguousarray(sigmas[POSE_SIZE:]),
            mass_survived=max(existence.survived, LEAST_PROBABILITY),
            mass_born=max(existence.born, LEAST_PROBABILITY),
            log_width=width_prior.log_width if width_prior is not None else 0.0,
            width_spread=width_prior.spread(parameters) if width_prior is not None else math.inf,
            births=births,
            mass_jumped=max(
                existence.survived * event_probability(BORDER_ERROR_RATE, dt), LEAST_PROBABILITY
            ),
            jump=self._jump_from(leader),
        )
        return predicted, existence

    def _draw_ancestors(self, belief: Belief, dt: float) -> tuple[Ancestors, float]:
        """Draw the particles that the new ones are drawn about; return the share that survives."""
        drawn = draw_ancestors(
            belief.particles,
            belief.hypotheses.clusters,
            min(self._parameters.ancestor_count, belief.particles.count),
            self._resample,
            self._rng,
        )
        return surviving_ancestors(
            drawn, belief.reference_angle, self._image_size, self._survival_rates, dt
        )

    def _jump_from(self, leader: FloatArray) -> BorderJump:
        """Return the density of cables that share one border with the leading one, (8,)."""
        lower, upper = (
            float(limit[StateColumn.WIDTH])
            for limit in (self._config.limits.lower, self._config.limits.upper)
        )
        return jump_from(leader, lower, upper, self._config.image_size[0])

    def _expected(self, belief: Belief, dt: float, motion: MotionAid | None) -> FloatArray:
        """Return where the clusters are expected, the one that leads first, shape (K, 8)."""
        expected: FloatArray = belief.hypotheses.clusters.means.copy()
        expected[:, :POSE_SIZE] = self._movement.expected(expected, dt, motion)[:, :POSE_SIZE]
        return expected

    def _concluded(
        self, before: Belief, found: Conclusion, expected: FloatArray, dt: float
    ) -> Belief:
        """Put the belief together, and remember the cable if it is there.

        Parameters
        ----------
        before : Belief
            Belief before the frame, aged to its time.
        found : Conclusion
            Particles, clusters and log-odds after the frame.
        expected : FloatArray
            Where the leading cluster was expected, shape (8,).
        dt : float
            Time since the frame before [s].
        """
        parameters, hypotheses = self._parameters, found.hypotheses
        presence = probability_of(float(found.log_odds[0]))
        is_known, is_clear = self._is_known(before), self._is_new_clear(hypotheses)
        is_refused = presence >= parameters.presence_to_track and (
            hypotheses.weaker_border_mean < parameters.evidence_to_lose
            if is_known
            else not is_clear
        )
        # Of what could not be claimed nothing is learnt: neither place nor width nor polarity.
        is_learnt_from = is_known or is_clear
        believed = presence if is_learnt_from else 0.0
        memory, width_prior = before.memory, before.width_prior
        leader = hypotheses.clusters.means[0]
        if believed >= MEMORY_PRESENCE and hypotheses.clusters.masses[0] >= MEMORY_MASS:
            memory = remember(wrap_state(leader), self._image_size, parameters)
            width = float(leader[StateColumn.WIDTH])
            width_prior = updated_width_prior(width_prior, width, dt, parameters)
        is_held = presence >= KNOWN_PRESENCE and is_same_hypothesis(
            leader, expected, self._config.same_hypothesis_radii
        )
        known_time = before.known_time + (dt if is_learnt_from else 0.0)
        return Belief(
            particles=Particles(found.states, found.log_weights),
            hypotheses=hypotheses,
            presence=presence,
            p_bright=updated_p_bright(
                before.p_bright, found.p_bright, believed, parameters.polarity_memory, dt
            ),
            memory=memory,
            width_prior=width_prior,
            log_odds=found.log_odds,
            refused_time=before.refused_time + dt if is_refused else 0.0,
            known_time=known_time if is_held else 0.0,
        )

    def _restarted_belief(self, before: Belief, births: BirthDensity) -> Belief:
        """Return the belief when every particle is impossible: that of a new search."""
        states = draw_births(births, self._parameters.particle_count, self._rng)
        return replace(
            initial_belief(states, LEAST_PRESENCE),
            p_bright=before.p_bright,
            memory=before.memory,
            width_prior=before.width_prior,
        )

    def summary(self, belief: Belief, image: WorkingImage) -> BeliefSummary:
        """Return what a belief says about the frame that it came from."""
        parameters, hypotheses = self._parameters, belief.hypotheses
        mean, covariance = self._leading_estimate(hypotheses)
        evidence = hypotheses.weaker_border_mean
        visible = hypotheses.visible_length >= MINIMUM_POINTS
        is_claimable = (
            visible
            and belief.presence >= parameters.presence_to_track
            and evidence >= parameters.evidence_to_track
        )
        return BeliefSummary(
            mean=mean,
            covariance=covariance,
            effective_sample_size=hypotheses.effective_size,
            evidence=evidence,
            supports_claim=is_claimable,
            supports_new_claim=is_claimable and self._is_new_clear(hypotheses),
            supports_keeping=visible
            and belief.presence >= parameters.presence_to_lose
            and evidence >= parameters.evidence_to_lose,
            presence=belief.presence,
            hypotheses=_reported(hypotheses.clusters),
        )

    def _is_new_clear(self, hypotheses: Hypotheses) -> bool:
        """Tell whether the leader is clear enough to claim it where nothing was known of it."""
        width = float(hypotheses.clusters.means[0, StateColumn.WIDTH])
        needed = needed_clearness(width, self._parameters, self._image_size[0])
        return hypotheses.scaled_clearness >= needed

    def _leading_estimate(self, hypotheses: Hypotheses) -> tuple[FloatArray, FloatArray]:
        """Return mean (8,) and covariance (8, 8) of the leading cluster, never across clusters."""
        leader = hypotheses.clusters.means[0]
        displaced = displaced_covariance(
            hypotheses.covariance,
            hypotheses.border_means,
            float(leader[StateColumn.WIDTH]),
            self._parameters,
            self._image_size[0],
        )
        return wrapped_estimate(leader, displaced)


def _reported(clusters: Clusters) -> tuple[Hypothesis, ...]:
    """Return the clusters that are worth mention, and the first whatever its mass."""
    masses, means = clusters.masses.tolist(), clusters.means
    return tuple(
        Hypothesis(mass, CableState.from_array(wrap_state(mean)))
        for index, (mass, mean) in enumerate(zip(masses, means, strict=True))
        if index == 0 or mass >= SMALLEST_HYPOTHESIS
    )
