"""The particle filter of this project: several hypotheses, and whether there is a cable at all.

Per frame, the particles stand for the density

    f(x) = P(survived) (sum_j W_j K(x | x_j) + r S(x)) + P(born) b(x)

of a cable in view, where K is the movement with its heavy tails about the particles x_j of the
frame before, S that of border switches, to cables that share one border with the leading
hypothesis, seldom (r) the right one, and b that of cables that come into view. They are not drawn
from f alone but from a mixture of proposals: from f, about what a detector sees, and, in rounds,
about the best particles of the same frame. A particle weighs f(x) L(x) / q(x), where q is the
density of the whole mixture and L the likelihood ratio of the frame: no proposal is a second prior,
wherever it comes from.

Whether a hypothesis is a cable at all is judged against strips drawn at random in the same frame,
see `background` and `presence`. Presence is the logistic of such a score of the leading
hypothesis, summed over its frames (`presence`); it is not the integral of f(x) L(x), as in a
Bernoulli filter. That filter's prediction alone is used: it gives P(survived) and P(born), by which
the parts of f are weighed and particles are shared out.

References
----------
M. Klaas, N. de Freitas and A. Doucet (2005), "Toward practical N^2 Monte Carlo: the marginal
particle filter": weights by the density of the whole mixture.
O. Cappe, A. Guillin, J.-M. Marin and C. Robert (2004), "Population Monte Carlo": the rounds.
B. Ristic et al. (2013), "A tutorial on Bernoulli filters": the prediction of existence.
B. Ristic, D. Clark, B.-N. Vo and B.-T. Vo (2012), "Adaptive target birth intensity for PHD and CPHD
filters": births about what is measured.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.filter_interface import BeliefSummary, ParticleBelief
from cable_tracker.cable.hypotheses.belief import (
    Belief,
    initial_belief,
    resampled_belief,
    without_fixture,
)
from cable_tracker.cable.hypotheses.births import draw_births
from cable_tracker.cable.hypotheses.claim import belief_summary, updated_belief
from cable_tracker.cable.hypotheses.conclusion import Conclusion, draw_and_conclude
from cable_tracker.cable.hypotheses.frame_inputs import (
    FrameInputs,
    beside_a_known_cable,
    draw_frame_noise,
    frame_config,
    sample_counts,
)
from cable_tracker.cable.hypotheses.prediction import (
    Prediction,
    Predictor,
    with_strips_in_birth_density,
)
from cable_tracker.cable.hypotheses.presence import (
    LEAST_PRESENCE,
    LIKELY_PRESENCE,
    is_same_hypothesis,
)
from cable_tracker.cable.hypotheses.proposals import empty_sample
from cable_tracker.cable.hypotheses.vehicle_fixture import fixture_test_after
from cable_tracker.cable.measure.borders.likelihood_ratio import (
    BorderLikelihoodRatio,
    polarity_prior,
)
from cable_tracker.cable.measure.map.cable_map import (
    CableMap,
    ExpectedOverlap,
    KeptMap,
    overlap_of_best,
    overlap_of_expected,
)
from cable_tracker.cable.measure.map.map_strips import map_borders, strips_of_map
from cable_tracker.cable.measure.picture.working_image import WorkingImage
from cable_tracker.cable.model.initial_state import search_box
from cable_tracker.cable.model.movement import CableMovement, MotionAid
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.particles import RESAMPLING_SCHEMES

GIVEN_PRESENCE = 0.95
"""Presence of a belief about a state that was given, or converted from another filter."""

MOST_OF_MAP = 2
"""Number of strips of the map about which cables are born, and which are candidates."""

STRAYING = 0.2
"""Deviation of the leader, see `Conclusion`, from which on a kept map is not used. It is moved with
the leader: once that is a shadow beside the cable, the map would show the shadow as cable. Chosen
on two held-out simulators, AH and AI."""

SAME_TIME = 1e-6
"""Tolerance of the age of a kept map, for rounding of the times between frames [s]."""

FIXTURE_FOUND = (
    "what was followed stands still in the picture while the ground moves: it is fixed to the"
    " vehicle, its shadow or its light, and no cable"
)
"""Event of the frame in which a fixture is found."""

NO_ANCHOR = np.empty((0, STATE_SIZE))
"""No expected state."""


class MultiHypothesisFilter:
    """Marginal particle filter with several hypotheses; see the module. It holds no belief itself.

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

    search_time = float("inf")
    """Time without a claim after which the tracker starts the search anew [s]: never; this filter
    does so by itself."""

    def __init__(
        self,
        parameters: TrackerParameters,
        observation: BorderLikelihoodRatio,
        image_size: tuple[int, int],
        rng: np.random.Generator,
    ) -> None:
        self._parameters = parameters
        self._uses_map = parameters.uses_map
        self._observation = observation
        self._image_size = image_size
        self._rng = rng
        self._resample = RESAMPLING_SCHEMES[parameters.resampling]
        self._movement = CableMovement(parameters, image_size[0])
        self._box = search_box(parameters, image_size[0])
        self._config = frame_config(parameters, self._movement.degrees_of_freedom, image_size)
        self._known_config = beside_a_known_cable(self._config, parameters)
        self._sample = empty_sample(parameters.particle_count)
        self._predictor = Predictor(parameters, self._movement, self._box, image_size, rng)

    def first_belief(self) -> Belief:
        """Return the belief at the begin of a search: particles all over the search box."""
        states = self._box.draw(self._parameters.particle_count, self._rng)
        return initial_belief(states, LEAST_PRESENCE)

    def given_belief(self, states: FloatArray, *, is_certain: bool = True) -> Belief:
        """Return a belief in states (N, 8); `is_certain`: an operator or planner gave them."""
        return replace(initial_belief(states, GIVEN_PRESENCE), is_given=is_certain)

    def converted(self, belief: ParticleBelief) -> Belief:
        """Return the belief of any filter as one of this, resampled to `particle_count`."""
        particles, count = belief.particles, self._parameters.particle_count
        if isinstance(belief, Belief) and particles.count == count:
            return belief
        indices = self._resample(particles.weights, count, self._rng)
        if isinstance(belief, Belief):
            return resampled_belief(belief, indices)
        return self.given_belief(particles.states[indices], is_certain=False)

    def step(
        self,
        belief: Belief,
        image: WorkingImage,
        dt: float,
        detections: FloatArray,
        motion: MotionAid | None = None,
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
        motion : MotionAid or None
            How odometry says that the cable has moved; None: by its own rates. None if `dt` is 0.
        """
        if belief.is_too_faint(self._parameters):
            belief = _new_search(self.first_belief(), belief)
        belief = belief.aged(dt)
        is_known = belief.is_known(self._parameters)
        prediction = self._predictor.predict(belief, dt, motion)
        looks = self._looks_at_map(belief, is_known=is_known)
        conclude = partial(
            self._concluded, belief, prediction, image, detections, is_known=is_known
        )
        conclusion = conclude(looks=looks)
        if not looks and self._uses_map and conclusion.deviation >= STRAYING:
            looks, conclusion = True, conclude(looks=True)
        if not len(conclusion.hypotheses.clusters.masses):
            # The poses of all particles are impossible.
            states = draw_births(
                prediction.density.births, self._parameters.particle_count, self._rng
            )
            return _new_search(initial_belief(states, LEAST_PRESENCE), belief)
        updated = updated_belief(
            belief, conclusion, dt, self._parameters, self._image_size, image.frame_scale,
            was_known=is_known,
        )  # fmt: skip
        updated = _with_map_of_frame(updated, image) if looks else updated
        return self._tested_for_fixture(updated, image, dt, goes_on=conclusion.goes_on)

    def _tested_for_fixture(
        self, belief: Belief, image: WorkingImage, dt: float, *, goes_on: bool
    ) -> Belief:
        """Return a belief after the fixture test: its leader is no cable if it is a fixture."""
        travel = self._parameters.fixture_travel * image.frame_scale
        if travel == 0.0:
            return belief
        leader, before = belief.hypotheses.clusters.means[0], belief.fixture_test
        test = fixture_test_after(before, leader, image, dt, travel, goes_on=goes_on)
        belief = replace(belief, fixture_test=test)
        radii = self._config.same_hypothesis_radii
        if test.fixture is None or not is_same_hypothesis(leader, test.fixture, radii):
            return belief
        return without_fixture(belief, "" if before.fixture is not None else FIXTURE_FOUND)

    def _looks_at_map(self, belief: Belief, *, is_known: bool) -> bool:
        """Tell whether the map of this frame is worked out, which takes most of its time.

        Not beside a known cable with two clear borders, while the kept map is recent.
        """
        are_clear = belief.hypotheses.weaker_border_mean >= self._parameters.evidence_to_find
        is_recent = belief.kept_map.seconds < self._parameters.map_interval - SAME_TIME
        return self._uses_map and not (is_known and are_clear and is_recent)

    def _concluded(
        self,
        belief: Belief,
        prediction: Prediction,
        image: WorkingImage,
        detections: FloatArray,
        *,
        is_known: bool,
        looks: bool,
    ) -> Conclusion:
        """Draw and weigh the particles of a frame, and return what is concluded from them.

        `is_known`: the hypothesis that led before is known. `looks`: the map of this frame is used,
        not the kept one.
        """
        expected = prediction.prior.expected[0]
        cable_map = image.cable_map if looks else belief.kept_map.moved_to(expected)
        if is_known:
            expected_overlap = overlap_of_expected(cable_map, expected, is_kept=not looks)
        else:
            strips = strips_of_map(cable_map, MOST_OF_MAP)
            expected_overlap = overlap_of_best(cable_map, strips)
            prediction = with_strips_in_birth_density(prediction, strips)
        inputs = self._inputs(belief, prediction, image, detections, cable_map, expected_overlap)
        config = self._known_config if is_known else self._config
        return draw_and_conclude(self._sample, inputs, config)

    def _inputs(
        self,
        belief: Belief,
        prediction: Prediction,
        image: WorkingImage,
        detections: FloatArray,
        cable_map: CableMap,
        expected_overlap: ExpectedOverlap,
    ) -> FrameInputs:
        """Return the inputs of the compiled conclusion, with the random numbers of the frame."""
        ancestor_count = len(prediction.density.rates)
        is_likely = belief.presence >= LIKELY_PRESENCE
        counts = sample_counts(
            self._parameters, prediction.density, len(detections), self._config.refined
        )
        noise = draw_frame_noise(
            self._rng,
            self._parameters.particle_count,
            counts.births,
            self._movement.degrees_of_freedom,
        )
        return FrameInputs(
            predicted=prediction.density,
            noise=noise,
            scan=image.scan,
            model=self._observation.model_for(image),
            cable_map=cable_map,
            expected_overlap=expected_overlap,
            polarity=polarity_prior(belief.p_bright),
            reference_angle=prediction.reference_angle,
            # Drawn with equal weights: those of the ancestors are in the density.
            ancestors=self._resample(
                np.full(ancestor_count, 1.0 / ancestor_count), counts.survivors, self._rng
            ),
            detected=detections,
            anchors=prediction.prior.expected[:1] if is_likely else NO_ANCHOR,
            counts=counts,
            prior=prediction.prior,
        )

    def summary(self, belief: Belief, image: WorkingImage) -> BeliefSummary:
        """Return what a belief says about the frame that it came from."""
        return belief_summary(belief, self._parameters, image.frame_scale)


def _with_map_of_frame(belief: Belief, image: WorkingImage) -> Belief:
    """Return a belief with the map of its frame as the kept one, and the borders it shows."""
    leader = belief.hypotheses.clusters.means[0]
    by_map = map_borders(leader, image.cable_map, image.pixels, image.reduction)
    borders = belief.kept_map.smoothed(by_map)
    return replace(belief, kept_map=KeptMap(image.cable_map, leader[:POSE_SIZE], borders))


def _new_search(first: Belief, before: Belief) -> Belief:
    """Return the first belief of a search, with the memory of the cable tracked before."""
    return replace(
        first, p_bright=before.p_bright, memory=before.memory, fixture_test=before.fixture_test
    )
