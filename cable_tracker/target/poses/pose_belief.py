"""Belief of the pose filter after a frame, and the density predicted from it for the next.

Part of it is the watch on rivals, other objects that resemble the target. Two of a kind never score
the same, and the better one would take the target over within a few frames, however far away it is.
While the target is observed where it is expected, the other one must be something else, so its
score is no evidence about the target. Near each other they may be told apart by their motion: two
that cross keep their rates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, shares_of
from cable_tracker.particle_filter.existence import predict_existence
from cable_tracker.particle_filter.particles import Particles, systematic_resampling
from cable_tracker.particle_filter.student_t import kernel_mixture
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.predicted_density import PredictedDensity
from cable_tracker.target.model.state import ANGLE, LOG_SCALE, POSE_SIZE, X, Y, wrap_full_turn
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.poses.known_target import KnownTarget, relearnt
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, pixel_scale
from cable_tracker.tracking.rates import (
    event_probability,
    over_time,
    share_about_last_place,
    survival_probability,
    survival_rates,
)

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
        return self.known.template.size * math.exp(self.estimate[LOG_SCALE])

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
