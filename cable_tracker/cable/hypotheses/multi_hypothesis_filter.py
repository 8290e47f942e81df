"""The particle filter of this project: several hypotheses, and whether there is a cable at all.

Per frame, the particles stand for the density

    f(x) = P(survived) sum_j W_j K(x | x_j) + P(born) b(x)

of a cable in view, where K is the movement with its heavy tails about the particles x_j of the
frame before, and b the density of cables that come into view. They are not drawn from f alone but
from a mixture of proposals: from f, about what a detector sees, and, in rounds, about the best
particles of the same frame. A particle weighs f(x) L(x) / q(x), where q is the density of the whole
mixture and L the likelihood ratio of the frame: no proposal is a second prior, wherever it comes
from. The sum of the weights is the likelihood ratio "a cable against none", which updates the
probability that there is one.

References
----------
M. Klaas, N. de Freitas and A. Doucet (2005), "Toward practical N^2 Monte Carlo: the marginal
particle filter": weights by the density of the whole mixture.
O. Cappe, A. Guillin, J.-M. Marin and C. Robert (2004), "Population Monte Carlo": the rounds.
B. Ristic et al. (2013), "A tutorial on Bernoulli filters": the probability of existence.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.cable.hypotheses.belief import Belief, initial_belief
from cable_tracker.cable.hypotheses.clusters import (
    SMALLEST_MASS,
    Cluster,
    clusters_of,
    find_clusters,
    find_groups,
)
from cable_tracker.cable.hypotheses.frame_noise import FrameNoise, draw_frame_noise
from cable_tracker.cable.hypotheses.leaving import BirthDensity, remember, survival_probabilities
from cable_tracker.cable.hypotheses.mixture_sample import Drawn, MixtureSample, Proposal
from cable_tracker.cable.hypotheses.prior_density import MINIMUM_DENSITY, Prior
from cable_tracker.cable.hypotheses.usual_width import width_seen
from cable_tracker.cable.measure.likelihood_ratio import (
    BorderLikelihoodRatio,
    bright_shares,
    marginal_log_ratios,
)
from cable_tracker.cable.measure.working_image import WorkingImage
from cable_tracker.cable.model.geometry import unwrap_states, wrap_states
from cable_tracker.cable.model.initialisation import search_box
from cable_tracker.cable.model.motion_aid import MotionAid
from cable_tracker.cable.model.movement import CableMovement
from cable_tracker.cable.model.state import PLACES, STATE_SIZE, StateColumn
from cable_tracker.cable.parameters.parameters import (
    REFERENCE_RATE,
    REFERENCE_WIDTH,
    TrackerParameters,
)
from cable_tracker.particle_filter.existence import (
    PredictedExistence,
    predict_existence,
    update_existence,
)
from cable_tracker.particle_filter.kernel_mixture import KernelMixture
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import RESAMPLING_SCHEMES
from cable_tracker.particle_filter.student_t import StudentT
from cable_tracker.particle_filter.weights import (
    effective_sample_size,
    log_sum_exp,
    normalise_log_weights,
)

GIVEN_PRESENCE = 0.9
"""Probability that there is a cable where somebody said that there is one."""

LEAST_PRESENCE, MOST_PRESENCE = 1e-3, 1.0 - 1e-5
"""The probability that there is a cable stays between these, so that it can turn again in time.
Close to 1, for a new cable beside the one that is tracked is hardly ever the one to follow."""

SMALLEST_CLUSTER_SHARE = 0.06
"""Share of the ancestors that every cluster has, however light: so it can prove itself."""

MEMORY_PRESENCE, MEMORY_MASS = 0.9, 0.7
"""A cable is remembered while it is present, and in one cluster, by so much."""

DETECTION_SIGMAS = np.array([3.0, np.deg2rad(1.5), 4.0, np.deg2rad(1.5)])
"""How far from a detection a cable is drawn: d, alpha, w, beta [px at the reference width, rad]."""

LOST_DETECTOR_SHARE = 0.3
"""Share of the particles about detections while it is more likely than not that there is none."""

LARGEST_BIRTH_SHARE = 0.8
"""Share of the particles of the prior that are born at most."""

LEAST_SURVIVING = 1e-300
"""Weight of an ancestor that cannot have survived: of none could a mixture be made."""

FIRST_POWER = 0.3
"""The first round looks at the frame through the likelihood to this power, the last one at it as it
is: the annealing that keeps a narrow peak from being missed."""

WIDENINGS = (1.5, 1.2)
"""Factor on the covariance of the particles that a round draws about: first round, later ones."""

SMALLEST_SIGMAS = np.array([0.15, np.deg2rad(0.08), 0.2, np.deg2rad(0.08)])
"""A round draws about particles with at least this scale [px at the reference width, rad]."""

MOST_REFINED, SMALLEST_REFINED = 3, 0.02
"""A round draws about so many clusters at most, each with at least this mass."""

SMALLEST_KERNEL = np.array([0.05, np.deg2rad(0.02), 0.05, np.deg2rad(0.02)])
"""Smallest scale of the movement [px at the reference width, rad]: without any, the particles could
not be told from points."""

BORDER_TURN = float(np.deg2rad(0.25))
"""Turn of a border that is displaced by one pixel of the reference width [rad]."""

POLARITY_DOUBT = 0.02
"""The probability that the cable is bright stays this far from 0 and 1."""


@dataclass(frozen=True, slots=True)
class Shares:
    """Numbers of particles by where they are drawn from.

    Attributes
    ----------
    survivors, births, detections : int
        Of the first round.
    refined : tuple of int
        Of each further round.
    """

    survivors: int
    births: int
    detections: int
    refined: tuple[int, ...]


class Survivors(NamedTuple):
    """What the particles of the frame before, M of them, have become.

    Attributes
    ----------
    places, rates : FloatArray
        Where they have drifted, and how fast they move, shape (M, 4).
    target : FloatArray
        Their weights, shape (M,), summing to one.
    survival : float
        Probability that the cable is still in view.
    """

    places: FloatArray
    rates: FloatArray
    target: FloatArray
    survival: float


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A frame, and how the cable in it is expected to look.

    Attributes
    ----------
    image : WorkingImage
        The frame.
    bright : float
        Probability that the cable is brighter than the bottom.
    """

    image: WorkingImage
    bright: float


class MultiHypothesisFilter:
    """See the module.

    Parameters
    ----------
    parameters : TrackerParameters
        All of them.
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
        self._parameters = parameters
        self._observation = observation
        self._image_size = image_size
        self._rng = rng
        self._resample = RESAMPLING_SCHEMES[parameters.resampling]
        self._movement = CableMovement(parameters, image_size[0])
        self._box = search_box(parameters, image_size[0])
        self._refined = tuple(
            int(parameters.refinement_share * parameters.particle_count * weight)
            for weight in round_weights(parameters.refinement_rounds)
        )
        self._unit = np.array([image_size[0] / REFERENCE_WIDTH, 1.0] * 2)
        self._smallest_kernel = SMALLEST_KERNEL * self._unit

    @cached_property
    def displacement(self) -> FloatArray:
        """The covariance (8, 8) of what the likelihood does not know.

        Growth, shadow and the roundness of a cable shift each border as a whole, by the same in
        frame after frame; particles agree on the wrong place then.
        """
        border = self._parameters.border_displacement * self._image_size[0] / REFERENCE_WIDTH
        turn = self._parameters.border_displacement * BORDER_TURN
        variances = np.zeros(STATE_SIZE)
        # d and alpha are means of the two borders, w is their difference, beta half of it.
        variances[:PLACES] = [border**2 / 2, turn**2 / 2, 2 * border**2, turn**2 / 2]
        return np.diag(variances)

    def leading_covariance(self, belief: Belief) -> FloatArray:
        """Return the covariance (8, 8) of the leading cluster, in the chart about its mean."""
        return belief.clusters[0].covariance(belief.particles.states, belief.particles.weights)

    def effective_sample_size(self, belief: Belief) -> float:
        """Return N_eff of all particles."""
        return effective_sample_size(belief.particles.log_weights)

    def first_belief(self) -> Belief:
        """Return what is believed of a cable of which nothing is known."""
        states = self._box.draw(self._parameters.particle_count, self._rng)
        return initial_belief(states, LEAST_PRESENCE, self._image_size[0])

    def belief_given(self, states: FloatArray) -> Belief:
        """Return what is believed of a cable that somebody said is there, states (N, 8)."""
        return initial_belief(states, GIVEN_PRESENCE, self._image_size[0])

    def adapted(self, belief: Belief) -> Belief:
        """Return the belief with the number of particles that the parameters want."""
        count = self._parameters.particle_count
        if belief.particles.count == count:
            return belief
        indices = self._resample(belief.particles.weights, count, self._rng)
        particles = belief.particles.selected(indices)
        clusters = find_clusters(particles.states, particles.weights, self._image_size[0])
        return replace(belief, particles=particles, clusters=tuple(clusters))

    def aid_by(self, motion: MotionAid | None) -> None:
        """Let cables move as odometry says until told otherwise; None: by their own rates."""
        self._movement.aid_by(motion)

    def step(
        self, belief: Belief, image: WorkingImage, dt: float, detections: FloatArray
    ) -> Belief:
        """Return the belief after one more frame.

        Parameters
        ----------
        belief : Belief
            After the frame before.
        image : WorkingImage
            The frame.
        dt : float
            Time between the two [s]; 0 for a belief about this very frame.
        detections : FloatArray
            d, alpha, w, beta of cables that a detector sees in it [px, rad], shape (K, 4).
        """
        view = View(image, belief.bright)
        prior = self._predict(belief, dt)
        shares = self._shares(prior.existence, len(detections))
        noise = self._noise(shares)
        sample = self._first_round(prior, shares, noise, view, detections)
        for number, count in enumerate(shares.refined):
            sample = self._refine(sample, prior, noise, view, number=number, count=count)
        return self._conclude(belief, prior, sample, dt)

    def _predict(self, belief: Belief, dt: float) -> Prior:
        survivors = self._survivors(belief, dt)
        count = len(survivors.target)
        # Without movement the kernel would be a point: the first frame after a given prior.
        sigmas = self._movement.diffusion_sigmas(max(dt, 1.0 / REFERENCE_RATE))
        memory = belief.memory.aged(dt) if belief.memory is not None else None
        usual_width = belief.usual_width.aged(dt) if belief.usual_width is not None else None
        return Prior(
            kernels=KernelMixture(
                survivors.places,
                np.maximum(sigmas[:PLACES], self._smallest_kernel),
                self._movement.degrees_of_freedom,
            ),
            target=survivors.target,
            proposal=np.full(count, 1.0 / count),
            rates=survivors.rates,
            rate_sigmas=sigmas[PLACES:],
            births=BirthDensity(self._box, memory, self._parameters.memory_time, self._image_size),
            existence=predict_existence(
                belief.presence,
                survivors.survival,
                -math.expm1(-self._parameters.appearance_rate * dt),
            ),
            reference_angle=belief.reference_angle,
            usual_width=usual_width,
            parameters=self._parameters,
            leader_shift=self._shift_of(belief.clusters[0].mean, dt),
        )

    def _shift_of(self, state: FloatArray, dt: float) -> FloatArray:
        """Return how far a state (8,) is expected to move in d, alpha, w, beta, shape (4,)."""
        if not self._movement.is_aided:
            return np.asarray(state[PLACES:] * self._movement.effective_time(dt))
        moved: FloatArray = self._movement.expected(state[None, :], dt)[0, :PLACES]
        return moved - state[:PLACES]

    def _survivors(self, belief: Belief, dt: float) -> Survivors:
        """Choose the particles that go on, and let them drift."""
        indices, weights = self._ancestors(belief)
        ancestors = unwrap_states(belief.particles.states[indices], belief.reference_angle)
        survival = survival_probabilities(ancestors, self._image_size, self._parameters, dt)
        surviving = np.maximum(weights * survival, LEAST_SURVIVING)
        drifted = self._movement.centres(ancestors, dt, self._rng)
        total = float(surviving.sum())
        places, rates = (np.ascontiguousarray(part) for part in np.hsplit(drifted, [PLACES]))
        return Survivors(places, rates, surviving / total, total)

    def _ancestors(self, belief: Belief) -> tuple[IndexArray, FloatArray]:
        """Choose the particles that go on: their indices and weights, shape (M,).

        Every cluster has some, light ones more than their weight; the weights make up for it.
        """
        weights = belief.particles.weights
        groups = [cluster.members for cluster in belief.clusters]
        groups.append(~np.any(groups, axis=0))
        masses = np.array([weights[members].sum() for members in groups])
        kept = np.flatnonzero(masses > SMALLEST_MASS)
        counts = self._ancestor_counts(masses[kept], belief.particles.count)
        chosen = []
        for group, number in zip(kept, counts, strict=True):
            members = np.flatnonzero(groups[group])
            shares = weights[members] / masses[group]
            chosen.append(members[self._resample(shares, int(number), self._rng)])
        target = np.repeat(masses[kept] / counts, counts)
        return np.concatenate(chosen), target / target.sum()

    def _ancestor_counts(self, masses: FloatArray, particles: int) -> IndexArray:
        """Return how many ancestors clusters of some masses (G,) have, shape (G,)."""
        wanted = np.maximum(masses, SMALLEST_CLUSTER_SHARE)
        count = min(self._parameters.ancestor_count, particles)
        counts: IndexArray = np.rint(wanted / wanted.sum() * count).astype(np.int64)
        return np.maximum(counts, 1)

    def _shares(self, existence: PredictedExistence, detections: int) -> Shares:
        parameters = self._parameters
        count = parameters.particle_count
        detector_share = parameters.detector_share if detections else 0.0
        if detector_share > 0.0 and existence.total < 0.5:
            detector_share = max(detector_share, LOST_DETECTOR_SHARE)
        detected = min(int(count * detector_share), max(count - sum(self._refined) - 1, 0))
        rest = count - sum(self._refined) - detected
        born = existence.born / max(existence.total, MINIMUM_DENSITY)
        births = int(rest * min(max(born, parameters.search_share), LARGEST_BIRTH_SHARE))
        return Shares(rest - births, births, detected, self._refined)

    def _noise(self, shares: Shares) -> FrameNoise:
        count, tail = self._parameters.particle_count, self._movement.degrees_of_freedom
        return draw_frame_noise(self._rng, count, shares.births, tail)

    def _first_round(
        self,
        prior: Prior,
        shares: Shares,
        noise: FrameNoise,
        view: View,
        detections: FloatArray,
    ) -> MixtureSample:
        ancestors = self._resample(prior.proposal, shares.survivors, self._rng)
        rows = slice(0, shares.survivors)
        places = prior.kernels.placed_about(ancestors, noise.of_places(rows))
        survivors = np.hstack((places, prior.rates_about(ancestors, noise.of_rates(rows))))
        rows = slice(rows.stop, rows.stop + shares.births)
        births = prior.births.placed(noise.uniform[rows], noise.about_memory)
        states = np.concatenate((survivors, births))
        proposals: tuple[tuple[int, Proposal], ...] = ()
        if shares.detections:
            mixture = self._about_detections(detections, prior.reference_angle)
            about = np.arange(shares.detections) % len(detections)
            rows = slice(rows.stop, rows.stop + shares.detections)
            places = mixture.placed_about(about, noise.of_places(rows))
            found = self._with_rates(places, prior, noise, rows)
            states = np.concatenate((states, found))
            proposals = ((shares.detections, mixture),)
        drawn = self._look(unwrap_states(states, prior.reference_angle), prior, view)
        return MixtureSample(drawn, shares.survivors, shares.births, proposals)

    def _about_detections(self, detections: FloatArray, reference_angle: float) -> KernelMixture:
        states = np.zeros((len(detections), STATE_SIZE))
        states[:, :PLACES] = detections
        centres = unwrap_states(states, reference_angle)[:, :PLACES]
        tail = self._movement.degrees_of_freedom
        return KernelMixture(centres, DETECTION_SIGMAS * self._unit, tail)

    def _with_rates(
        self, places: FloatArray, prior: Prior, noise: FrameNoise, rows: slice
    ) -> FloatArray:
        states = np.zeros((len(places), STATE_SIZE))
        states[:, :PLACES] = places
        states = unwrap_states(states, prior.reference_angle)
        states[:, PLACES:] = prior.rates_from(states, noise.uniform[rows], noise.of_rates(rows))
        return states

    def _look(self, states: FloatArray, prior: Prior, view: View) -> Drawn:
        evidence = self._observation.measure(states, view.image)
        width_factors = prior.log_width_factors(states)
        log_ratios = marginal_log_ratios(evidence.log_ratios, view.bright) + width_factors
        possible = self._movement.is_within_limits(states)
        return Drawn(
            states,
            prior.log_densities(states),
            np.where(possible, log_ratios, -np.inf),
            width_factors,
            evidence,
        )

    def _refine(
        self,
        sample: MixtureSample,
        prior: Prior,
        noise: FrameNoise,
        view: View,
        *,
        number: int,
        count: int,
    ) -> MixtureSample:
        """Draw `count` more particles about the best ones so far, in round `number`."""
        power = annealing_power(number, self._parameters.refinement_rounds)
        normalised = normalise_log_weights(sample.log_weights(power))
        if normalised.degenerate or count == 0:
            return sample
        masses, peaks = self._peaks(
            sample.drawn.states, np.exp(normalised.log_weights), widening_in(number)
        )
        proposals = tuple(zip(allot(count, masses), peaks, strict=True))
        start = len(sample.drawn.states)
        standard = noise.of_places(slice(start, start + count))
        parts = np.split(standard, np.cumsum([drawn for drawn, _ in proposals])[:-1])
        places = np.concatenate(
            [peak.placed(part) for (_, peak), part in zip(proposals, parts, strict=True)]
        )
        states = self._with_rates(places, prior, noise, slice(start, start + count))
        return sample.extended(self._look(states, prior, view), proposals)

    def _peaks(
        self, states: FloatArray, weights: FloatArray, widening: float
    ) -> tuple[FloatArray, list[StudentT]]:
        """Return masses and shapes of the clusters that a round draws about, heaviest first."""
        clusters = find_clusters(states, weights, self._image_size[0])[:MOST_REFINED]
        worthy = [clusters[0], *(each for each in clusters[1:] if each.mass >= SMALLEST_REFINED)]
        smallest = np.diag((SMALLEST_SIGMAS * self._unit) ** 2)
        peaks = []
        for cluster in worthy:
            spread = cluster.covariance(states, weights)[:PLACES, :PLACES]
            factor = np.linalg.cholesky(widening * spread + smallest).astype(np.float64)
            tail = self._movement.degrees_of_freedom
            peaks.append(StudentT(cluster.mean[:PLACES], factor, tail))
        return np.array([cluster.mass for cluster in worthy]), peaks

    def _conclude(self, before: Belief, prior: Prior, sample: MixtureSample, dt: float) -> Belief:
        states = wrap_states(sample.drawn.states)
        groups = self._groups(before, prior, sample)
        if not groups:
            return self._spread(before, prior)
        log_weights = self._balanced(sample, groups, prior)
        presence = update_existence(
            prior.existence, log_sum_exp(log_weights), LEAST_PRESENCE, MOST_PRESENCE
        )
        particles = Particles(states, normalise_log_weights(log_weights).log_weights)
        weights = particles.weights
        # Balancing may leave all named groups light and the rest heavy.
        clusters = clusters_of(groups, states, weights)
        clusters = clusters or find_clusters(states, weights, self._image_size[0])
        leader = clusters[0]
        evidence = sample.drawn.evidence
        shares = bright_shares(evidence.log_ratios, before.bright)
        weaker = np.where(
            shares >= 0.5, evidence.weaker_borders[:, 0], evidence.weaker_borders[:, 1]
        )
        within = weights * leader.members / leader.mass
        return self._belief_of(
            before,
            prior,
            dt,
            particles,
            tuple(clusters),
            presence=presence,
            clearness=float(within @ weaker),
            seen=float(within @ evidence.seen),
            brightness=float(weights @ shares),
        )

    def _belief_of(
        self,
        before: Belief,
        prior: Prior,
        dt: float,
        particles: Particles,
        clusters: tuple[Cluster, ...],
        *,
        presence: float,
        clearness: float,
        seen: float,
        brightness: float,
    ) -> Belief:
        """Put the belief together, and remember the cable if it is there."""
        leader = clusters[0]
        memory, usual_width = prior.births.memory, prior.usual_width
        if presence >= MEMORY_PRESENCE and leader.mass >= MEMORY_MASS:
            memory = remember(leader.state, self._image_size, self._parameters)
            width = float(leader.mean[StateColumn.WIDTH])
            usual_width = width_seen(before.usual_width, width, dt, self._parameters)
        return Belief(
            particles=particles,
            clusters=clusters,
            presence=presence,
            bright=self._polarity(before.bright, brightness, presence, dt),
            memory=memory,
            usual_width=usual_width,
            evidence=clearness,
            seen=seen,
        )

    def _groups(self, before: Belief, prior: Prior, sample: MixtureSample) -> list[BoolArray]:
        """Return the members of each cluster; the one that leads has the first choice."""
        return find_groups(
            wrap_states(sample.drawn.states),
            sample.log_weights(1.0),
            self._image_size[0],
            self._anchor(before, prior),
        )

    def _anchor(self, before: Belief, prior: Prior) -> FloatArray | None:
        """Return where the cluster that leads is expected, shape (8,); None if none leads."""
        if before.presence < 0.5:
            return None
        anchor: FloatArray = before.clusters[0].mean.copy()
        anchor[:PLACES] += prior.leader_shift
        return anchor

    def _balanced(self, sample: MixtureSample, groups: list[BoolArray], prior: Prior) -> FloatArray:
        """Return log-weights (N,) in which frame after frame does not count as independent.

        Particles of one group compete by their likelihood. Between groups, and for whether there is
        a cable at all, what counts is how much better the frame is explained, less what any bottom
        explains as well, up to a limit, and in full only once: a furrow that is there in this frame
        is there in the next.
        """
        log_weights, log_prior = sample.log_weights(1.0), sample.log_weights(0.0)
        log_survived = log_prior + sample.drawn.densities.log_share_of_survivors()
        balanced = log_weights.copy()
        rest = ~np.any(groups, axis=0)
        for members in (*groups, rest):
            posterior_mass = log_sum_exp(log_weights[members]) if members.any() else -math.inf
            if posterior_mass == -math.inf:
                continue
            prior_mass = log_sum_exp(log_prior[members])
            evidence = posterior_mass - prior_mass
            survived = min(math.exp(log_sum_exp(log_survived[members]) - prior_mass), 1.0)
            shares = np.exp(log_weights[members] - posterior_mass)
            misfit = float(shares @ sample.drawn.width_factors[members])
            balanced[members] += self._counted(evidence, misfit, survived) - evidence
        return balanced

    def _counted(self, evidence: float, misfit: float, survived: float) -> float:
        """Return what of the evidence for a group counts, of which a share survived.

        `misfit` is what its width speaks against it: the clearest rope is no cable.
        """
        parameters = self._parameters
        limit = parameters.evidence_limit + misfit
        new = min(evidence - parameters.evidence_of_bottom, limit)
        return new * (survived * parameters.evidence_repeated + (1.0 - survived))

    def _spread(self, before: Belief, prior: Prior) -> Belief:
        """Return what is left to believe when every particle is impossible: a new search."""
        states = prior.births.draw(self._parameters.particle_count, self._rng)
        spread = initial_belief(states, LEAST_PRESENCE, self._image_size[0])
        return replace(
            spread,
            bright=before.bright,
            memory=prior.births.memory,
            usual_width=prior.usual_width,
        )

    def _polarity(self, before: float, seen: float, presence: float, dt: float) -> float:
        memory = self._parameters.polarity_memory ** (dt * REFERENCE_RATE)
        now = presence * seen + (1.0 - presence) * before
        bright = memory * now + (1.0 - memory) * 0.5
        return float(min(max(bright, POLARITY_DOUBT), 1.0 - POLARITY_DOUBT))


def annealing_power(number: int, rounds: int) -> float:
    """Return the power of the likelihood in a round: from `FIRST_POWER` up to 1 in the last."""
    if rounds == 1:
        return FIRST_POWER
    return float(FIRST_POWER ** (1.0 - number / (rounds - 1)))


def widening_in(number: int) -> float:
    """Return the factor on the covariance of the particles that a round draws about."""
    return WIDENINGS[min(number, len(WIDENINGS) - 1)]


def round_weights(rounds: int) -> list[float]:
    """Return the share of each round; the last, which counts most, has more than the others."""
    if rounds == 0:
        return []
    parts = [1.0] * (rounds - 1) + [1.5]
    return [part / sum(parts) for part in parts]


def allot(count: int, masses: FloatArray) -> list[int]:
    """Split a number in proportion to masses (K,); what rounding leaves goes to the first."""
    counts = [int(count * share) for share in masses / masses.sum()]
    counts[0] += count - sum(counts)
    return counts
