"""Belief of the pose filter after a frame, and the density predicted from it for the next."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray, shares_of
from cable_tracker.particle_filter.existence import predict_existence
from cable_tracker.particle_filter.particles import Particles, systematic_resampling
from cable_tracker.particle_filter.student_t import kernel_mixture
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.predicted_density import PredictedDensity
from cable_tracker.target.model.state import ANGLE, POSE_SIZE, X, Y, wrap_full_turn
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.known_target import KnownTarget, relearnt
from cable_tracker.target.poses.rivals import RivalWatch
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, pixel_scale
from cable_tracker.tracking.rates import (
    event_probability,
    over_time,
    share_about_last_place,
    survival_probability,
    survival_rates,
)


@dataclass(frozen=True, slots=True, eq=False)
class PoseBelief:
    """Belief after a frame, in pixels of the working image.

    Attributes
    ----------
    particles : Particles
        Poses, shape (N, 6).
    estimate : FloatArray
        Their mean about the best of them, shape (6,).
    presence : float
        Probability that the target is in view.
    known : KnownTarget
        Shape, appearance, usual scores and size of the target.
    rivals : RivalWatch
        Watch on objects that resemble it.
    """

    particles: Particles
    estimate: FloatArray
    presence: float
    known: KnownTarget
    rivals: RivalWatch

    @property
    def size(self) -> float:
        """Root of the area of the target that is expected [px]."""
        return self.known.size_at(self.estimate)

    @property
    def angle(self) -> float:
        """Angle of the estimate [rad]."""
        return float(self.estimate[ANGLE])

    def aged(
        self,
        frame: WorkingFrame,
        dt: float,
        motion: CameraMotion | None,
        parameters: TargetParameters,
    ) -> PoseBelief:
        """Return the belief moved with the camera to the time of a new frame.

        Where colour comes or goes, the appearance of a target that is surely in view is learnt
        anew.
        """
        belief = replace(self, known=replace(self.known, births=self.known.births.aged(dt)))
        if motion is not None:
            belief = belief._moved(motion, frame)
        if belief.presence >= parameters.presence_to_track and belief._differs_in_colour(frame):
            known = relearnt(belief.known, belief.estimate, frame, parameters)
            belief = replace(belief, known=known)
        return belief

    def _differs_in_colour(self, frame: WorkingFrame) -> bool:
        """Return whether a frame is grey for a target that was learnt in colour, or the converse.

        In between, with colour in a few pixels, it is measured as the target was learnt.
        """
        return not frame.has_chroma if self.known.is_coloured else frame.is_coloured

    def _moved(self, motion: CameraMotion, frame: WorkingFrame) -> PoseBelief:
        zoom = frame.zoom
        return replace(
            self,
            particles=self.particles.moved_to(motion.moved(self.particles.states, zoom)),
            estimate=motion.moved(self.estimate[None], zoom)[0],
            known=replace(self.known, births=self.known.births.moved(motion, zoom)),
        )


def predict_density(
    belief: PoseBelief,
    shape: tuple[int, int],
    dt: float,
    parameters: TargetParameters,
    rng: np.random.Generator,
) -> PredictedDensity:
    """Return the predicted density of the poses in a frame.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns of the frame.
    dt : float
        Time since the frame before [s].
    rng : numpy.random.Generator
        Draws the ancestors.
    """
    frames = dt * REFERENCE_RATE
    states = belief.particles.states
    drawn = systematic_resampling(belief.particles.weights, parameters.ancestor_count, rng)
    ancestors = states[drawn]
    damping = 1.0 if belief.rivals.is_near else parameters.rate_damping
    rates = ancestors[:, POSE_SIZE:] * over_time(damping, dt)
    centres = ancestors[:, :POSE_SIZE].copy()
    centres[:, :2] += rates * dt
    angles = centres[:, ANGLE]
    centres[:, ANGLE] = belief.angle + wrap_full_turn(angles - belief.angle)
    survival = _survival(centres, shape, dt, parameters)
    predicted = predict_existence(
        belief.presence, float(survival.mean()), event_probability(parameters.appearance_rate, dt)
    )
    # None can be in view after a long time with high rates: then all are as likely.
    alive = shares_of(survival)
    kernels = kernel_mixture(
        centres,
        _diffusion(frames, shape[1], parameters),
        parameters.diffusion_degrees_of_freedom,
        alive,
    )
    births = belief.known.births
    memory_share = share_about_last_place(births.seconds, parameters.memory_time)
    jumps = parameters.jump_share * belief.rivals.jump_factor
    return PredictedDensity(kernels, rates, alive, births, memory_share, predicted, jumps)


def _survival(
    centres: FloatArray, shape: tuple[int, int], dt: float, parameters: TargetParameters
) -> FloatArray:
    """Return the probabilities that poses (M, 4) remain in view, shape (M,)."""
    height, width = shape
    x, y = centres[:, X], centres[:, Y]
    inside = np.minimum(width / 2 - np.abs(x), height / 2 - np.abs(y))
    rates = survival_rates(
        parameters.disappearance_rate, parameters.leaving_rate, parameters.leaving_margin, width
    )
    return survival_probability(inside, rates, dt)


def _diffusion(frames: float, width: int, parameters: TargetParameters) -> FloatArray:
    """Return the scales of the diffusion's kernel over some frames of 25 Hz, shape (4,)."""
    reference_scale = pixel_scale(width)
    root = math.sqrt(frames)
    position = math.sqrt(parameters.position_variance) * reference_scale * root
    scale, angle = parameters.scale_sigma * root, math.radians(parameters.angle_sigma) * root
    scales: FloatArray = np.maximum([position, position, scale, angle], 1e-6)
    return scales
