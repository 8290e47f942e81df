"""Where the particles start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.cable.model.limits import clip_to_limits, possible_limits, state_limits
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE, CableState, StateColumn
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import compiled_inside
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, pixel_scale

Range = TypeVar("Range", float, FloatArray)

SMALLEST_RANGE = 1e-6
"""Smallest width of the search box in d, alpha, w, beta [px, rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class GivenState:
    """Where a cable is said to be, and how exactly: by an operator, a planner, or ground truth.

    Attributes
    ----------
    state : CableState
        Mean [px, rad, per second].
    sigma : FloatArray
        Standard deviations, shape (8,) [px, rad, per second]. An infinite one means "not known":
        that component is drawn as in a random start. NaN means "not said": the component is taken
        as known well, see `usual_sigma`.
    is_guess : bool
        Whether it may be another thing than the cable, as what a detector finds.
    """

    state: CableState
    sigma: FloatArray
    is_guess: bool = False

    @classmethod
    def around(cls, state: CableState, *, is_guess: bool = False) -> GivenState:
        """Return what is given of a state that is known well."""
        return cls(state, np.full(STATE_SIZE, np.nan), is_guess)

    @property
    def is_certain(self) -> bool:
        """Whether d, alpha, w and beta are all given, and are those of the cable."""
        return not self.is_guess and not bool(np.isinf(self.sigma[:POSE_SIZE]).any())

    def words(self) -> str:
        """Return what is known of d, alpha, w and beta, for a log."""
        state = self.state
        known = [
            words
            for words, sigma in zip(
                (
                    f"d {state.distance:.1f} px",
                    f"alpha {state.angle:.3f} rad",
                    f"w {state.width:.1f} px",
                    f"beta {state.skew:.3f} rad",
                ),
                self.sigma,
                strict=False,
            )
            if not np.isinf(sigma)
        ]
        return ", ".join(known) or "nothing is known"


def usual_sigma(image_width: int) -> FloatArray:
    """Return the spread about a state that is known well, shape (8,): 2 px, half a degree."""
    scale = pixel_scale(image_width)
    half_degree = float(np.deg2rad(0.5))
    return np.array(
        [
            2.0 * scale,
            half_degree,
            2.0 * scale,
            half_degree,
            0.5 * scale * REFERENCE_RATE,
            0.1 * half_degree * REFERENCE_RATE,
            0.2 * scale * REFERENCE_RATE,
            0.04 * half_degree * REFERENCE_RATE,
        ]
    )


@dataclass(frozen=True, slots=True, eq=False)
class SearchBox:
    """The cables among which a search without knowledge draws, all alike (thesis, Table 5.2).

    Attributes
    ----------
    lower, upper : FloatArray
        Shape (8,) [px, rad, per second].
    """

    lower: FloatArray
    upper: FloatArray

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw cables, shape (count, 8)."""
        return between(self.lower, self.upper, rng.random((count, STATE_SIZE)))


@compiled_inside
def between(lower: Range, upper: Range, share: Range) -> Range:
    """Return what lies at a share, from 0 to 1, of the way between two limits."""
    return lower + share * (upper - lower)


def search_box(parameters: TrackerParameters, image_width: int) -> SearchBox:
    """Return the box for frames of a given width [px]: what of the search is possible."""
    scale = pixel_scale(image_width)
    distance = parameters.initial_distance_range * scale
    angle = np.deg2rad(parameters.initial_angle_range)
    distance_rate = parameters.initial_distance_rate_range * scale * REFERENCE_RATE
    angle_rate = np.deg2rad(parameters.initial_angle_rate_range) * REFERENCE_RATE
    lower = np.array(
        [-distance, -angle, parameters.initial_width_minimum * scale,
         np.deg2rad(parameters.initial_skew_minimum), -distance_rate, -angle_rate, 0.0, 0.0]
    )  # fmt: skip
    upper = np.array(
        [distance, angle, parameters.initial_width_maximum * scale,
         np.deg2rad(parameters.initial_skew_maximum), distance_rate, angle_rate, 0.0, 0.0]
    )  # fmt: skip
    limits = possible_limits(parameters, image_width)
    # A range of zero would make the uniform density infinite.
    lower[:POSE_SIZE] = np.clip(lower[:POSE_SIZE], limits.lower, limits.upper - SMALLEST_RANGE)
    upper[:POSE_SIZE] = np.clip(upper[:POSE_SIZE], lower[:POSE_SIZE] + SMALLEST_RANGE, limits.upper)
    return SearchBox(lower, upper)


def random_states(
    parameters: TrackerParameters, image_width: int, rng: np.random.Generator
) -> FloatArray:
    """Draw states uniformly from the ranges of Table 5.2, shape (N, 8), within the limits."""
    states = search_box(parameters, image_width).draw(parameters.particle_count, rng)
    return clip_to_limits(wrap_states(states), state_limits(parameters, image_width))


def draw_given_states(
    given: GivenState,
    parameters: TrackerParameters,
    image_width: int,
    rng: np.random.Generator,
) -> FloatArray:
    """Draw states from the Gaussian about a given one, shape (N, 8), within the limits."""
    states = random_states(parameters, image_width, rng)
    noise = rng.standard_normal(states.shape)
    usual = usual_sigma(image_width)
    # With zero rate variance the model never changes a rate: one drawn here would stay, so none is
    # drawn.
    if parameters.width_rate_variance == 0.0:
        usual[StateColumn.WIDTH_RATE] = 0.0
    if parameters.skew_rate_variance == 0.0:
        usual[StateColumn.SKEW_RATE] = 0.0
    sigma = np.where(np.isnan(given.sigma), usual, given.sigma)
    known = np.isfinite(sigma)
    drawn = given.state.to_array() + noise * np.where(known, sigma, 0.0)
    states[:, known] = drawn[:, known]
    return clip_to_limits(wrap_states(states), state_limits(parameters, image_width))
