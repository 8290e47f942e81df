"""Where the particles start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import wrap_states
from cable_tracker.cable.model.limits import clip_to_limits, possible_limits, state_limits
from cable_tracker.cable.model.state import (
    ANGLE,
    DISTANCE,
    POSE_SIZE,
    POSE_WORDS,
    SKEW_RATE,
    STATE_SIZE,
    WIDTH_RATE,
    CableState,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.compilation import compiled_inside
from cable_tracker.errors import FrameError
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, pixel_scale

Range = TypeVar("Range", float, FloatArray)

HUGE = 1e15
"""Standard deviations beyond it say nothing, "not known", and rates beyond it are none [px, rad,
per second]. Rates have no limits: drawn so, their covariance would not be finite."""

SMALLEST_RANGE = 1e-6
"""Smallest width of the search box in d, alpha, w, beta [px, rad]."""


class GivenPoint(NamedTuple):
    """A point that a cable passes through, whatever its direction.

    Attributes
    ----------
    x, y : float
        Place in the image frame [px].
    sigma : float
        Standard deviation in every direction [px]. NaN means "not said".
    """

    x: float
    y: float
    sigma: float

    @property
    def is_acceptable(self) -> bool:
        """Whether its place is finite and its sigma not negative."""
        return math.isfinite(self.x) and math.isfinite(self.y) and not self.sigma < 0.0

    def distances(self, angles: FloatArray) -> FloatArray:
        """Return d of the lines through the point with angles (N,), shape (N,) [px]."""
        distances: FloatArray = self.x * np.cos(angles) + self.y * np.sin(angles)
        return distances


@dataclass(frozen=True, slots=True, eq=False)
class GivenState:
    """Where a cable is said to be, and how exactly: by an operator, a planner, or ground truth.

    Attributes
    ----------
    state : CableState
        Mean [px, rad, per second].
    sigma : FloatArray
        Standard deviations, shape (8,) [px, rad, per second]. An infinite one, or one beyond
        `HUGE`, which becomes infinite, means "not known": that component is drawn as in a
        random start. NaN means "not said": the component is taken as known well, see `usual_sigma`.
    is_guess : bool
        Whether it may be another thing than the cable, as what a detector finds.
    point : GivenPoint or None
        Where the cable passes, if that is all that is known of d and alpha.

    Raises
    ------
    FrameError
        The sigmas are not eight numbers.
    """

    state: CableState
    sigma: FloatArray
    is_guess: bool = False
    point: GivenPoint | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "sigma", _eight_sigmas(self.sigma))

    @classmethod
    def around(cls, state: CableState, *, is_guess: bool = False) -> GivenState:
        """Return what is given of a state that is known well."""
        return cls(state, np.full(STATE_SIZE, np.nan), is_guess)

    @property
    def is_acceptable(self) -> bool:
        """Whether what is given is finite, no rate beyond `HUGE`, and no sigma negative."""
        is_point_acceptable = self.point is None or self.point.is_acceptable
        are_rates_acceptable = bool((np.abs(self.state.to_array()[POSE_SIZE:]) <= HUGE).all())
        is_state_acceptable = self.state.is_finite() and are_rates_acceptable
        return is_state_acceptable and not bool(np.any(self.sigma < 0.0)) and is_point_acceptable

    @property
    def is_certain(self) -> bool:
        """Whether d, alpha, w and beta are all given, and are those of the cable."""
        return not self.is_guess and not bool(np.isinf(self.sigma[:POSE_SIZE]).any())

    def describe(self) -> str:
        """Describe what is known of d, alpha, w and beta, or of a point, for a log."""
        known = [
            words.format(value)
            for words, value, sigma in zip(
                POSE_WORDS, self.state.to_array(), self.sigma, strict=False
            )
            if not np.isinf(sigma)
        ]
        if self.point is not None:
            known.insert(0, f"through x {self.point.x:.1f} px, y {self.point.y:.1f} px")
        return ", ".join(known) or "nothing is known"


def _eight_sigmas(given: ArrayLike) -> FloatArray:
    """Return standard deviations (8,) as they were given, huge ones infinite.

    Raises
    ------
    FrameError
        They are not eight numbers.
    """
    try:
        sigma = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        sigma = np.empty(0)
    if sigma.shape != (STATE_SIZE,):
        raise FrameError(
            "give eight standard deviations of a start: of d, alpha, w, beta and of their rates;"
            " inf where one is not known, NaN where it is not said"
        )
    return np.where(sigma > HUGE, np.inf, sigma)


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


class SearchBox(NamedTuple):
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
        usual[WIDTH_RATE] = 0.0
    if parameters.skew_rate_variance == 0.0:
        usual[SKEW_RATE] = 0.0
    sigma = np.where(np.isnan(given.sigma), usual, given.sigma)
    known = np.isfinite(sigma)
    mean = given.state.to_array()
    drawn = mean + noise * np.where(known, sigma, 0.0)
    limits = state_limits(parameters, image_width)
    if known[DISTANCE]:
        drawn[:, DISTANCE] = _possible_distances(
            drawn[:, DISTANCE], states[:, DISTANCE],
            mean[DISTANCE], limits.upper[DISTANCE],
        )  # fmt: skip
    states[:, known] = drawn[:, known]
    if given.point is not None:
        states[:, DISTANCE] = _distances_through(
            given.point, states[:, ANGLE], noise[:, DISTANCE], usual
        )
    return clip_to_limits(wrap_states(states), limits)


def _possible_distances(
    drawn: FloatArray, even: FloatArray, mean: float, limit: float
) -> FloatArray:
    """Return distances (N,) that were drawn about a mean, without those that only its doubt made.

    Where the doubt is as wide as the picture, many lie beyond the limit, and would be piled up on
    it. The even ones of a random start take their place. About a mean that is known well, at a
    limit or beyond it, those are less likely than what was drawn: that is left to the limit.
    """
    is_wild = (np.abs(drawn) > limit) & (abs(mean) <= limit)
    is_nearer = np.abs(even - mean) <= np.abs(drawn - mean)
    return np.where(is_wild & is_nearer, even, drawn)


def _distances_through(
    point: GivenPoint, angles: FloatArray, noise: FloatArray, usual: FloatArray
) -> FloatArray:
    """Return distances of lines with angles (N,) that pass a point, with standard noise (N,)."""
    sigma = usual[DISTANCE] if math.isnan(point.sigma) else point.sigma
    return point.distances(angles) + sigma * noise
