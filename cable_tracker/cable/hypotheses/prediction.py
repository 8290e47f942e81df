"""What is known of the cable before a frame is looked at: densities, existence, and hypotheses."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.ancestors import (
    Ancestors,
    draw_ancestors,
    survival_rates,
    surviving_ancestors,
)
from cable_tracker.cable.hypotheses.belief import Belief
from cable_tracker.cable.hypotheses.births import birth_density_of
from cable_tracker.cable.hypotheses.border_jump import BORDER_ERROR_RATE, BorderJump, jump_from
from cable_tracker.cable.hypotheses.predicted_density import LEAST_PROBABILITY, PredictedDensity
from cable_tracker.cable.hypotheses.presence import PriorPresence, gain_over
from cable_tracker.cable.model.initial_state import SearchBox
from cable_tracker.cable.model.limits import state_limits
from cable_tracker.cable.model.motion_aid import MotionAid
from cable_tracker.cable.model.movement import CableMovement
from cable_tracker.cable.model.state import POSE_SIZE, StateColumn, pose_units
from cable_tracker.cable.parameters.parameters import REFERENCE_RATE, TrackerParameters
from cable_tracker.particle_filter.existence import PredictedExistence, predict_existence
from cable_tracker.particle_filter.kernel_mixture import kernel_mixture
from cable_tracker.particle_filter.resampling import RESAMPLING_SCHEMES
from cable_tracker.tracking.rates import event_probability

SMALLEST_KERNEL = np.array([0.05, np.deg2rad(0.02), 0.05, np.deg2rad(0.02)])
"""Lower bound of the kernel scales [px at the reference width, rad]: a scale of zero has no
density."""


class Prediction(NamedTuple):
    """What is known of the cable before a frame is looked at.

    Attributes
    ----------
    existence : PredictedExistence
        Probabilities that a cable has survived and that one has been born.
    density : PredictedDensity
        The density f of cables in view; its `births` are those that come into view.
    prior : PriorPresence
        Prior of the log-odds of the hypotheses, and their expected states.
    """

    existence: PredictedExistence
    density: PredictedDensity
    prior: PriorPresence


class Predictor:
    """Predicts beliefs, for frames of one size.

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
        self._box = box
        self._image_size = image_size
        self._rng = rng
        self._resample = RESAMPLING_SCHEMES[parameters.resampling]
        self._survival_rates = survival_rates(parameters, width)
        self._smallest_kernel = SMALLEST_KERNEL * pose_units(width)
        self._limits = state_limits(parameters, width)

    def predict(self, belief: Belief, dt: float, motion: MotionAid | None) -> Prediction:
        """Predict a belief, aged to the frame, over the `dt` seconds since the frame before."""
        parameters, memory = self._parameters, belief.memory
        births = birth_density_of(self._box, memory, parameters.memory_time, self._image_size)
        expected = self._expected(belief, dt, motion)
        birth = event_probability(parameters.appearance_rate, dt)
        ancestors, survival = self._draw_ancestors(belief, dt)
        existence = predict_existence(belief.presence, survival, birth)
        prior = PriorPresence(
            expected=expected,
            log_odds=belief.log_odds,
            survival=existence.survived / max(belief.presence, LEAST_PROBABILITY),
            birth=birth,
            gain=gain_over(parameters.presence_gain, dt),
            is_known=belief.is_known(parameters.known_after),
        )
        drifted = self._movement.draw_centres(ancestors.states, dt, self._rng, motion)
        sigmas = self._kernel_sigmas(dt, motion)
        density = PredictedDensity(
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
            log_width=memory.log_width if memory is not None else 0.0,
            width_spread=memory.width_spread(parameters) if memory is not None else math.inf,
            births=births,
            mass_jumped=max(
                existence.survived * event_probability(BORDER_ERROR_RATE, dt), LEAST_PROBABILITY
            ),
            jump=self._jump_from(expected[0]),
        )
        return Prediction(existence, density, prior)

    def _expected(self, belief: Belief, dt: float, motion: MotionAid | None) -> FloatArray:
        """Return the expected states of the clusters, the leading one first, shape (K, 8)."""
        expected: FloatArray = belief.hypotheses.clusters.means.copy()
        expected[:, :POSE_SIZE] = self._movement.expected(expected, dt, motion)[:, :POSE_SIZE]
        return expected

    def _draw_ancestors(self, belief: Belief, dt: float) -> tuple[Ancestors, float]:
        """Draw the particles that go on, weighed by their survival; return that of the cable."""
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

    def _kernel_sigmas(self, dt: float, motion: MotionAid | None) -> FloatArray:
        """Return the scales of the diffusion about the drifted ancestors, shape (8,)."""
        # Without movement the kernel would be a point: the first frame after a given prior.
        return self._movement.diffusion_sigmas(max(dt, 1.0 / REFERENCE_RATE), motion)

    def _jump_from(self, leader: FloatArray) -> BorderJump:
        """Return the density of cables that share one border with the leading one, (8,)."""
        lower, upper = (
            float(limit[StateColumn.WIDTH]) for limit in (self._limits.lower, self._limits.upper)
        )
        return jump_from(leader, lower, upper, float(self._image_size[0]))
