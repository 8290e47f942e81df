"""Prediction of a belief to the next frame: density of the state, existence, log-odds."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.belief import Belief, RememberedCable
from cable_tracker.cable.hypotheses.births import (
    BIRTH_PEAK,
    BORDER_SWITCH_RATE,
    OFFSET_SIGMA,
    BirthDensity,
    BorderSwitch,
    births_anywhere,
)
from cable_tracker.cable.hypotheses.clusters import SMALLEST_MASS, Clusters
from cable_tracker.cable.hypotheses.predicted_density import (
    LEAST_PROBABILITY,
    PredictedDensity,
)
from cable_tracker.cable.hypotheses.presence import PriorPresence
from cable_tracker.cable.model.geometry import inset, state_in_chart, states_in_chart
from cable_tracker.cable.model.initial_state import SearchBox
from cable_tracker.cable.model.limits import possible_limits
from cable_tracker.cable.model.movement import CableMovement, Diffusion, MotionAid
from cable_tracker.cable.model.state import ANGLE, POSE_SIZE, WIDTH, pose_units
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import compiled
from cable_tracker.particle_filter.particles import RESAMPLING_SCHEMES, Particles, ResamplingScheme
from cable_tracker.particle_filter.student_t import kernel_mixture
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, pixel_scale
from cable_tracker.tracking.rates import (
    SurvivalRates,
    event_probability,
    over_time,
    share_about_last_place,
    survival_probability,
    survival_rates,
)

SMALLEST_KERNEL = np.array([0.05, np.deg2rad(0.02), 0.05, np.deg2rad(0.02)])
"""Lower bound of the kernel scales d, alpha, w, beta [px at the reference width, rad]."""

SMALLEST_CLUSTER_SHARE = 0.06
"""Minimum share of the ancestors that are drawn from each cluster."""

MOST_RATED = 2.0 / REFERENCE_RATE
"""Upper bound of the time over which a hypothesis is extrapolated by its rates [s]. They are means
of few particles: over longer gaps their noise moves it farther than most cables go."""

LEAST_SURVIVING = 1e-300
"""Lower bound of an ancestor's weight, so that the weights can be normalised."""


class Ancestors(NamedTuple):
    """Particles of a frame that those of the next one are drawn about.

    Attributes
    ----------
    states : FloatArray
        Particles of the frame before, shape (M, 8).
    weights : FloatArray
        Their weights in the predicted density, shape (M,), summing to one. Of a light cluster more
        are drawn than its mass asks for, with weights that are smaller in proportion.
    """

    states: FloatArray
    weights: FloatArray


class Prediction(NamedTuple):
    """Belief predicted to the time of a frame, before its picture is used.

    Attributes
    ----------
    density : PredictedDensity
        The density f of cables in view; its `births` are those that come into view.
    prior : PriorPresence
        Prior of the log-odds of the hypotheses, and their expected states.
    reference_angle : float
        Angle of the leading hypothesis [rad]; normals of all particles are written within pi/2 of
        it.
    """

    density: PredictedDensity
    prior: PriorPresence
    reference_angle: float


def with_strips_in_birth_density(prediction: Prediction, strips: FloatArray) -> Prediction:
    """Return a prediction whose birth density has a part about the strips of a map, (C, 8)."""
    in_chart = states_in_chart(strips, prediction.reference_angle)
    births = prediction.density.births._replace(map_strips=in_chart)
    return prediction._replace(density=prediction.density._replace(births=births))


class Predictor:
    """Predicts a belief from frame to frame, for frames of one size.

    Parameters
    ----------
    parameters : TrackerParameters
        The tracker's parameters.
    movement : CableMovement
        Drift and diffusion of the cable.
    box : SearchBox
        Box of the births that are not about a remembered cable.
    image_size : (int, int)
        Width and height of the frames [px].
    rng : numpy.random.Generator
        The source of randomness.
    """

    def __init__(
        self,
        parameters: TrackerParameters,
        movement: CableMovement,
        box: SearchBox,
        image_size: tuple[int, int],
        rng: np.random.Generator,
    ) -> None:
        width = image_size[0]
        self._parameters = parameters
        self._movement = movement
        self._image_size = image_size
        self._rng = rng
        self._resample = RESAMPLING_SCHEMES[parameters.resampling]
        self._frame_scale = pixel_scale(width)
        self._survival_rates = survival_rates(
            parameters.disappearance_rate, parameters.leaving_rate, parameters.leaving_margin, width
        )
        self._births_anywhere = births_anywhere(box, image_size, self._frame_scale)
        self._smallest_kernel = SMALLEST_KERNEL * pose_units(self._frame_scale)
        limits = possible_limits(parameters, width)
        self._widths = float(limits.lower[WIDTH]), float(limits.upper[WIDTH])

    def predict(self, belief: Belief, dt: float, motion: MotionAid | None) -> Prediction:
        """Predict a belief, aged to the frame, over the `dt` seconds since the frame before."""
        parameters, means = self._parameters, belief.hypotheses.clusters.means
        reference_angle = float(means[0, ANGLE])
        drawn = draw_ancestors(
            belief.particles,
            belief.hypotheses.clusters,
            min(parameters.ancestor_count, len(belief.particles.states)),
            self._resample,
            self._rng,
        )
        ancestors, survival = surviving_ancestors(
            drawn, reference_angle, self._image_size, self._survival_rates, dt
        )
        births, memory = self._births_anywhere, belief.memory
        if memory is not None:
            births = births_with_memory(births, memory, parameters.memory_time, self._frame_scale)
        birth = event_probability(parameters.appearance_rate, dt)
        survived, born = belief.presence * survival, (1.0 - belief.presence) * birth
        switched = survived * event_probability(BORDER_SWITCH_RATE, dt)
        # In the first frame after a given prior dt is 0, and a kernel would be a point.
        time = dt if dt > 0.0 else 1.0 / REFERENCE_RATE
        # Consecutive frames look alike, the less the longer the time between them.
        gain = 1.0 - over_time(1.0 - parameters.presence_gain, time)
        rated = dt if motion is not None else min(dt, MOST_RATED)
        expected = means.copy()
        expected[:, :POSE_SIZE] = self._movement.expected(means, rated, motion)[:, :POSE_SIZE]
        drifted = self._movement.draw_centres(ancestors.states, dt, self._rng, motion)
        diffusion = self._movement.diffusion(time, motion)
        masses = survived, born, switched
        density = self._density(
            masses, births, ancestors.weights, drifted, diffusion, expected[0], memory
        )
        prior = PriorPresence(
            expected=expected, log_odds=belief.log_odds, survival=survival, birth=birth, gain=gain
        )
        return Prediction(density, prior, reference_angle)

    def _density(
        self,
        masses: tuple[float, float, float],
        births: BirthDensity,
        weights: FloatArray,
        drifted: FloatArray,
        diffusion: Diffusion,
        leader: FloatArray,
        memory: RememberedCable | None,
    ) -> PredictedDensity:
        """Return the density of cables in view.

        `masses`: probabilities that a cable in view was in the frame before, that it was not, and
        that the leading hypothesis had one border wrong. `weights` (M,), `drifted` (M, 8): those of
        the ancestors. `leader`: expected state of the leading hypothesis, shape (8,).
        """
        survived, born, switched = (max(mass, LEAST_PROBABILITY) for mass in masses)
        return PredictedDensity(
            kernels=kernel_mixture(
                np.ascontiguousarray(drifted[:, :POSE_SIZE]),
                np.maximum(diffusion.pose_scales, self._smallest_kernel),
                self._movement.degrees_of_freedom,
                weights,
            ),
            rates=np.ascontiguousarray(drifted[:, POSE_SIZE:]),
            rate_gains=diffusion.rate_gains,
            rate_scales=np.ascontiguousarray(diffusion.rate_scales),
            mass_survived=survived,
            mass_born=born,
            log_width=memory.log_width if memory is not None else 0.0,
            width_spread=memory.width_spread(self._parameters) if memory is not None else math.inf,
            births=births,
            mass_switched=switched,
            border_switch=switch_from(leader, *self._widths, self._frame_scale),
        )


def draw_ancestors(
    particles: Particles,
    clusters: Clusters,
    count: int,
    resample: ResamplingScheme,
    rng: np.random.Generator,
) -> Ancestors:
    """Draw ancestors by weight, at least `SMALLEST_CLUSTER_SHARE` of them from each cluster.

    Parameters
    ----------
    particles, clusters : Particles, Clusters
        The belief after the frame before.
    count : int
        Number of ancestors.
    resample : ResamplingScheme
        Resampling scheme.
    rng : numpy.random.Generator
        The source of randomness.
    """
    # The particles of no cluster have the label -1, so that theirs is the last factor.
    masses = np.append(clusters.masses, clusters.rest)
    heavy = masses > SMALLEST_MASS
    oversampling = np.zeros(len(masses))
    oversampling[heavy] = np.maximum(masses[heavy], SMALLEST_CLUSTER_SHARE) / masses[heavy]
    factors = oversampling[clusters.labels]
    frequencies = particles.weights * factors
    indices = resample(frequencies / frequencies.sum(), count, rng)
    weights = 1.0 / factors[indices]
    return Ancestors(particles.states[indices], weights / weights.sum())


@compiled
def surviving_ancestors(
    ancestors: Ancestors,
    reference_angle: float,
    image_size: tuple[int, int],
    rates: SurvivalRates,
    dt: float,
) -> tuple[Ancestors, float]:
    """Return the ancestors reweighted by their survival, and the total survival probability.

    Each is weighted by its probability of staying in view for `dt`.

    Parameters
    ----------
    ancestors : Ancestors
        Ancestors with their weights after the frame before.
    reference_angle : float
        Angle within pi/2 of which their normals are written [rad].
    image_size : (int, int)
        Width and height of the frames [px].
    rates : SurvivalRates
        Rates at which a cable goes out of view.
    dt : float
        Time to the next frame [s].
    """
    states, weights = np.empty_like(ancestors.states), np.empty_like(ancestors.weights)
    survival = 0.0
    for row in range(len(weights)):
        state = states[row]
        state_in_chart(ancestors.states[row], reference_angle, state)
        within = inset(state, image_size[0], image_size[1])
        surviving = ancestors.weights[row] * survival_probability(within, rates, dt)
        weights[row] = max(surviving, LEAST_SURVIVING)
        survival += weights[row]
    for row in range(len(weights)):
        weights[row] /= survival
    return Ancestors(states, weights), survival


def births_with_memory(
    anywhere: BirthDensity, memory: RememberedCable, memory_time: float, frame_scale: float
) -> BirthDensity:
    """Return a density of births a share of which is about the cable that was tracked before.

    `memory_time` is the time constant of that share [s], `frame_scale` that of `births_anywhere`.
    """
    scales = memory.scales(frame_scale)
    return anywhere._replace(
        pose=memory.pose,
        scales=scales,
        share=share_about_last_place(memory.seconds, memory_time),
        side=memory.side,
        inset=memory.inset,
        peak=BIRTH_PEAK / math.prod(scales.tolist()),
    )


def switch_from(
    leader: FloatArray, narrowest: float, widest: float, frame_scale: float
) -> BorderSwitch:
    """Return the density of border switches from a hypothesis, shape (4 or more,), in its chart.

    `frame_scale`: see `WorkingImage`.
    """
    distance, angle, width, skew = leader[:POSE_SIZE].tolist()
    return BorderSwitch(
        np.array([distance - 0.5 * width, distance + 0.5 * width]),
        np.array([angle - skew, angle + skew]),
        skew,
        narrowest,
        widest,
        OFFSET_SIGMA * frame_scale,
    )
