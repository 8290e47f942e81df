"""The Blob-FICVM filter of J. Ha (2008), Table 7: every particle evolves a contour of its own.

A particle is a place; about it lies the window of the level set of the shape prior, moved as a
whole. Its contour evolves by a few iterations where the contrast is high enough, and its weight
comes from the energy of the contour and from how far its shape is from the prior. The best particle
is the estimate; its contour becomes the prior where contrast is high and the shapes are near.
Resampled every frame. Where the thesis is silent (`blob_shape_limit`; what counts as lost: no
contour worth evolving) the choice is ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.contour.evolution import ContourSettings, evolve
from cable_tracker.contour.shapes import level_set_energy
from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.particles import (
    Particles,
    effective_sample_size,
    multinomial_resampling,
)
from cable_tracker.target.filter_interface import TargetSummary
from cable_tracker.target.measure.outline import Outline
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.state import LOG_SCALE, STATE_SIZE, UNKNOWN_COVARIANCE, X, Y
from cable_tracker.target.model.template import LEAST_AREA, centroid, check_area
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.thesis.border_model import BorderModel
from cable_tracker.target.thesis.weights import blob_weights, horizon_weights
from cable_tracker.tracking.image_frame import image_centre, to_pixel
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, pixel_scale

MARGIN = 0.5
"""The window reaches beyond the shape by this share of its sides."""

LEAST_MARGIN = 4
"""Lower bound of that margin [px]."""

REGULARISER = ContourSettings(regulariser=0.02, balance=0.02, flooding=False)
"""rho_1 and eps_N: the thesis gives neither."""


@dataclass(frozen=True, slots=True, eq=False)
class ShapePrior:
    """The shape that is expected, in a window about it.

    Attributes
    ----------
    mask : BoolArray
        Inside, shape (h, w).
    first_area : int
        Pixels of the shape that was marked.
    """

    mask: BoolArray
    first_area: int

    @property
    def area(self) -> int:
        """Pixels inside."""
        return int(self.mask.sum())


@dataclass(frozen=True, slots=True, eq=False)
class Blob:
    """One particle's contour.

    Attributes
    ----------
    mask : BoolArray
        In its window.
    left, top : int
        Column and row of the window's first pixel.
    image_energy : float
        Variance about the two means, per pixel of the window: (9) over its area.
    shape_energy : float
        (19, 20) against the prior [px² of an image 320 px wide].
    contrast : float
        Difference of the means.
    """

    mask: BoolArray
    left: int
    top: int
    image_energy: float
    shape_energy: float
    contrast: float


@dataclass(frozen=True, slots=True, eq=False)
class BlobBelief:
    """Belief after a frame, in pixels of the working image.

    Attributes
    ----------
    particles : Particles
        Places, as poses, shape (N, 6).
    prior : ShapePrior
        Shape that is expected.
    before : array
        Intensities of the frame, float32, shape (H, W).
    border : BorderModel
        State of the model for targets that leave the picture.
    """

    particles: Particles
    prior: ShapePrior
    before: NDArray[np.float32]
    border: BorderModel


class BlobFilter:
    """Filter of blobs; see the module. It holds no belief itself.

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
    ) -> tuple[TargetSummary, BlobBelief]:
        """Take the pixels of a target for the prior of its shape.

        Raises
        ------
        FrameError
            The mask is too small or fills the picture, or its contrast is too low for a contour.
        """
        check_area(mask, frame.zoom)
        if mask.all():
            raise FrameError("the marked target fills the picture; mark only the target")
        image = _intensities(frame)
        contrast = abs(float(image[mask].mean() - image[~mask].mean()))
        if contrast < self._parameters.blob_contrast:
            raise FrameError(
                f"the marked target does not stand out from its surroundings (contrast"
                f" {contrast:.2f}, needs {self._parameters.blob_contrast:.2f})"
            )
        prior = ShapePrior(_cut_about(mask), int(mask.sum()))
        estimate = np.zeros(STATE_SIZE)
        estimate[:2] = centroid(mask)
        states = np.tile(estimate, (self._parameters.particle_count, 1))
        belief = BlobBelief(Particles.equally_weighted(states), prior, image, BorderModel())
        blob = self._blob_at(image, prior.mask, estimate)
        if blob is None:
            raise FrameError(
                "the marked target leaves too little of the picture around it for a contour; mark"
                " one with surroundings"
            )
        return self._summarised(frame, belief, blob, estimate, float(len(states)), claims=True)

    def step(
        self,
        belief: BlobBelief,
        frame: WorkingFrame,
        dt: float,
        motion: CameraMotion | None,
        others: FloatArray,
        *,
        counts_for: float,
    ) -> tuple[TargetSummary, BlobBelief]:
        """Follow the target into the next frame; see `PoseFilter.step`.

        `others` and `counts_for` are ignored: the shape follows at once.
        """
        image, mask = _intensities(frame), belief.prior.mask
        states = self._moved(belief, frame, dt, motion)
        parameters = self._parameters
        if parameters.blob_model == "near_horizon":
            corners = [_corner(state, mask, frame.shape) for state in states]
            weights = horizon_weights(image, belief.before, mask, corners)
            best = int(np.argmax(weights))
            blob = self._blob_at(image, mask, states[best])
        else:
            blobs = [self._blob_at(image, mask, state) for state in states]
            weights = blob_weights(
                np.array([each.image_energy if each else np.inf for each in blobs]),
                np.array([each.shape_energy if each else np.inf for each in blobs]),
                np.array([each.contrast if each else 0.0 for each in blobs]),
                parameters.blob_weights,
            )
            best = int(np.argmax(weights))
            blob = blobs[best]
        estimate, border = states[best], belief.border
        chosen = multinomial_resampling(weights, parameters.particle_count, self._rng)
        n_eff = effective_sample_size(np.log(np.maximum(weights, 1e-300)))
        particles = Particles.equally_weighted(states[chosen])
        is_seen = blob is not None and blob.contrast >= parameters.blob_contrast
        if parameters.blob_model == "boundary":
            border = border.after(estimate, frame.shape, is_seen, self._rng)
        belief = BlobBelief(particles, belief.prior, image, border)
        if blob is None:
            return _absent_summary(estimate, n_eff), belief
        return self._summarised(frame, belief, blob, estimate, n_eff, claims=is_seen)

    def _moved(
        self, belief: BlobBelief, frame: WorkingFrame, dt: float, motion: CameraMotion | None
    ) -> FloatArray:
        """Return the places after a random walk."""
        states = belief.particles.states.copy()
        if motion is not None:
            states = motion.moved(states, frame.zoom)
        reference_scale = pixel_scale(frame.shape[1])
        sigma = (
            math.sqrt(self._parameters.position_variance * dt * REFERENCE_RATE) * reference_scale
        )
        states[:, :2] += sigma * self._rng.standard_normal((len(states), 2))
        if self._parameters.blob_model == "boundary":
            states = belief.border.placed(states, frame.shape, self._rng)
        return states

    def _blob_at(
        self, image: NDArray[np.float32], mask: BoolArray, state: FloatArray
    ) -> Blob | None:
        """Return the contour of a particle, evolved where the contrast is high enough.

        `mask` is that of the prior of its shape.
        """
        height, width = mask.shape
        column, row = _corner(state, mask, image.shape)
        left, top = max(column, 0), max(row, 0)
        right, bottom = min(column + width, image.shape[1]), min(row + height, image.shape[0])
        if right - left < 3 or bottom - top < 3:
            return None
        cut = np.ascontiguousarray(image[top:bottom, left:right])
        start = np.ascontiguousarray(mask[top - row : bottom - row, left - column : right - column])
        inside = int(start.sum())
        if min(inside, start.size - inside) < LEAST_AREA:
            return None
        means = float(cut[start].mean()), float(cut[~start].mean())
        found, contrast = start, abs(means[0] - means[1])
        if contrast >= self._parameters.blob_contrast:
            settings = REGULARISER._replace(iterations=self._parameters.blob_iterations)
            contour = evolve(cut, start, settings, by_means=True)
            found, contrast = contour.mask, contour.contrast
            means = contour.inside_mean, contour.outside_mean
        energy = (cut[found] - means[0]) @ (cut[found] - means[0])
        energy += (cut[~found] - means[1]) @ (cut[~found] - means[1])
        unlike = level_set_energy(found, start) / pixel_scale(image.shape[1]) ** 2
        return Blob(found, left, top, float(energy) / cut.size, unlike, contrast)

    def _summarised(
        self,
        frame: WorkingFrame,
        belief: BlobBelief,
        blob: Blob,
        estimate: FloatArray,
        n_eff: float,
        *,
        claims: bool,
    ) -> tuple[TargetSummary, BlobBelief]:
        """Take the contour over as the prior where it is near; return summary and belief.

        `estimate` (6,) is the pose of the particle whose contour that is.
        """
        prior, states = belief.prior, belief.particles.states
        is_near = blob.shape_energy <= self._parameters.blob_shape_limit
        outline = Outline(
            blob.mask,
            (blob.left, blob.top, blob.left + blob.mask.shape[1], blob.top + blob.mask.shape[0]),
            1.0 if is_near else 0.0,
        )
        touches = outline.touches_border(frame.shape)
        area = outline.area
        state = estimate.copy()
        state[LOG_SCALE] = 0.5 * math.log(max(area, 1) / prior.first_area)
        if claims and is_near and not touches and area >= LEAST_AREA:
            whole = outline.in_picture(frame.shape)
            belief = replace(belief, prior=replace(prior, mask=_cut_about(whole)))
            state[:2] = centroid(whole)
        summary = TargetSummary(
            state=state,
            covariance=np.cov(states.T) if len(states) > 1 else np.zeros((STATE_SIZE, STATE_SIZE)),
            outline=outline,
            is_whole=is_near and not touches,
            presence=1.0 if claims else 0.0,
            effective_sample_size=n_eff,
            score=blob.contrast,
            supports_claim=claims,
            supports_keeping=claims,
        )
        return summary, belief


def _absent_summary(estimate: FloatArray, n_eff: float) -> TargetSummary:
    """Return the summary of a frame in which no part of the target can be."""
    return TargetSummary(
        state=estimate.copy(),
        covariance=UNKNOWN_COVARIANCE,
        outline=None,
        is_whole=False,
        presence=0.0,
        effective_sample_size=n_eff,
        score=0.0,
        supports_claim=False,
        supports_keeping=False,
    )


def _intensities(frame: WorkingFrame) -> NDArray[np.float32]:
    scaled: NDArray[np.float32] = frame.grey.astype(np.float32) / np.float32(255.0)
    return scaled


def _cut_about(mask: BoolArray) -> BoolArray:
    """Return a mask with an even margin about its centroid, also beyond the picture."""
    rows, columns = np.nonzero(mask)
    sides = int(np.ptp(columns)) + 1, int(np.ptp(rows)) + 1
    reach_x = round((0.5 + MARGIN) * sides[0]) + LEAST_MARGIN
    reach_y = round((0.5 + MARGIN) * sides[1]) + LEAST_MARGIN
    padded = np.pad(mask, ((reach_y, reach_y), (reach_x, reach_x)))
    row, column = round(float(rows.mean())) + reach_y, round(float(columns.mean())) + reach_x
    cut: BoolArray = padded[
        row - reach_y : row + reach_y + 1, column - reach_x : column + reach_x + 1
    ].copy()
    return cut


def _corner(state: FloatArray, mask: BoolArray, shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the column and row of a window's first pixel."""
    column, row = to_pixel(float(state[X]), float(state[Y]), (shape[1], shape[0]))
    middle_column, middle_row = image_centre((mask.shape[1], mask.shape[0]))
    return round(column - middle_column), round(row - middle_row)
