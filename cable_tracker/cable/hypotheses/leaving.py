"""How a cable leaves the image, and where to look for it then.

Whether it is in view is a Markov chain, see `cable_tracker.tracking.survival`. A cable that has
left is looked for along the border over which it went, one that vanished in the middle (buried, or
hidden) about where it was; the longer it is gone, the farther from there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import unwrap_states, wrap_states
from cable_tracker.cable.model.initialisation import SearchBox
from cable_tracker.cable.model.state import PLACES, STATE_SIZE, StateColumn
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH, TrackerParameters
from cable_tracker.particle_filter.student_t import student_t_log_density
from cable_tracker.tracking.survival import SurvivalRates, share_about_last_place
from cable_tracker.tracking.survival import survival_probabilities as generic_survival_probabilities

SPREAD = np.array([4.0, math.radians(2.0), 3.0, math.radians(1.0)])
"""How far from where it was a cable is looked for at once: d, alpha, w, beta [px at the reference
width, rad]."""

SPREADING = np.array([100.0, math.radians(37.0), 50.0, math.radians(7.5)])
"""How much farther after every second [px/s at the reference width, rad/s]."""

WIDEST = np.array([120.0, math.radians(60.0), 40.0, math.radians(10.0)])
"""How far at most; what is farther is found by the search without knowledge."""

TAIL = 4.0
"""Degrees of freedom of the Student-t about where the cable was."""

MOST_TURNS = 2
"""Half turns that an angle may be drawn away from the remembered one; hardly any goes farther."""

LEFT_MARGIN = 3.0
"""A cable was leaving if it was nearer to the edge than this many `leaving_margin`."""


def support(angles: FloatArray, image_size: tuple[int, int]) -> FloatArray:
    """Return the largest |d| at which a line still meets the image [px], of the angles' shape."""
    width, height = image_size
    reach: FloatArray = (np.abs(np.cos(angles)) * width + np.abs(np.sin(angles)) * height) / 2
    return reach


def distance_inside(states: FloatArray, image_size: tuple[int, int]) -> FloatArray:
    """Return how far each centreline is from leaving the image [px], shape (N,).

    Negative for those that have left.
    """
    angles, distances = states[:, StateColumn.ANGLE], states[:, StateColumn.DISTANCE]
    inside: FloatArray = support(angles, image_size) - np.abs(distances)
    return inside


def inset(state: FloatArray, image_size: tuple[int, int]) -> float:
    """Return how far one centreline, shape (4,) or more, is from leaving the image [px]."""
    angle, distance = float(state[StateColumn.ANGLE]), float(state[StateColumn.DISTANCE])
    width, height = image_size
    return (abs(math.cos(angle)) * width + abs(math.sin(angle)) * height) / 2 - abs(distance)


def survival_probabilities(
    states: FloatArray, image_size: tuple[int, int], parameters: TrackerParameters, dt: float
) -> FloatArray:
    """Return the probability that each cable is still in view `dt` seconds later, shape (N,)."""
    rates = survival_rates(parameters, image_size[0])
    return generic_survival_probabilities(distance_inside(states, image_size), rates, dt)


def survival_rates(parameters: TrackerParameters, image_width: int) -> SurvivalRates:
    """Return how often a cable leaves frames of a given width [px]."""
    return SurvivalRates(
        vanishing=parameters.disappearance_rate,
        leaving=parameters.leaving_rate,
        margin=parameters.leaving_margin * image_width / REFERENCE_WIDTH,
    )


@dataclass(frozen=True, slots=True, eq=False)
class RememberedCable:
    """Where a cable was when it was last tracked.

    Attributes
    ----------
    places : FloatArray
        d, alpha, w, beta, shape (4,) [px, rad].
    side : float
        Sign of d if it was leaving the image there; 0 if it was not.
    seconds : float
        How long ago that was [s].
    """

    places: FloatArray
    side: float
    seconds: float = 0.0

    def aged(self, dt: float) -> RememberedCable:
        """Return the same memory `dt` seconds later."""
        return replace(self, seconds=self.seconds + dt)


def remember(
    state: FloatArray, image_size: tuple[int, int], parameters: TrackerParameters
) -> RememberedCable:
    """Return the memory of a cable, shape (8,), that is tracked now."""
    margin = LEFT_MARGIN * parameters.leaving_margin * image_size[0] / REFERENCE_WIDTH
    leaving = inset(state, image_size) < margin
    side = float(np.sign(state[StateColumn.DISTANCE])) if leaving else 0.0
    return RememberedCable(state[:PLACES].copy(), side)


@dataclass(frozen=True, slots=True, eq=False)
class BirthDensity:
    """Where a cable that was not in view comes into it.

    Attributes
    ----------
    box : SearchBox
        Anywhere.
    memory : RememberedCable or None
        Near here, mostly, if a cable was seen before.
    memory_time : float
        After which the memory counts for 1/e [s].
    image_size : (int, int)
        Width and height of the frames [px].
    """

    box: SearchBox
    memory: RememberedCable | None
    memory_time: float
    image_size: tuple[int, int]

    @property
    def memory_share(self) -> float:
        """Share of the births about the remembered cable."""
        if self.memory is None:
            return 0.0
        return share_about_last_place(self.memory.seconds, self.memory_time)

    def remembered_of(self, count: int) -> int:
        """Return how many of `count` births are about the remembered cable."""
        return round(self.memory_share * count)

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw cables with their angle in (-pi/2, pi/2], shape (count, 8)."""
        uniform = rng.random((count, STATE_SIZE))
        return wrap_states(self.placed(uniform, rng.standard_t(TAIL, (count, PLACES))))

    def placed(self, uniform: FloatArray, about_memory: FloatArray) -> FloatArray:
        """Return the cables, at any angle, for random numbers, shape (N, 8).

        Parameters
        ----------
        uniform : FloatArray
            From 0 to 1, shape (N, 8).
        about_memory : FloatArray
            Student-t of `TAIL` degrees of freedom, shape (N, 4).
        """
        states = self.box.placed(uniform)
        remembered = self.remembered_of(len(states))
        if self.memory is not None and remembered:
            noise = about_memory[:remembered] * self.scales(self.memory)
            angles = self.memory.places[StateColumn.ANGLE] + noise[:, StateColumn.ANGLE]
            places = self._centres(self.memory, angles) + noise
            states[:remembered] = np.zeros((remembered, STATE_SIZE))
            states[:remembered, :PLACES] = places
        return states

    def log_density(self, states: FloatArray) -> FloatArray:
        """Return the log-density of d, alpha, w, beta, shape (N,), for states (N, 8)."""
        anywhere = self.box.log_density_of_places(wrap_states(states))
        if self.memory is None:
            return anywhere
        share = self.memory_share
        near = self._log_density_near(states, self.memory)
        mixed: FloatArray = np.logaddexp(np.log1p(-share) + anywhere, math.log(share) + near)
        return mixed

    def _log_density_near(self, states: FloatArray, memory: RememberedCable) -> FloatArray:
        # Angles are drawn far enough to go round: a line is met however it is written.
        angle = float(memory.places[StateColumn.ANGLE])
        ways = [
            self._log_density_in(unwrap_states(states, angle + turn * math.pi), memory)
            for turn in range(-MOST_TURNS, MOST_TURNS + 1)
        ]
        total: FloatArray = np.logaddexp.reduce(ways)
        return total

    def _log_density_in(self, chart: FloatArray, memory: RememberedCable) -> FloatArray:
        scales = self.scales(memory)
        offsets = chart[:, :PLACES] - self._centres(memory, chart[:, StateColumn.ANGLE])
        # The components are independent, given the angle.
        squared = (offsets / scales) ** 2
        total: FloatArray = student_t_log_density(squared, 1, TAIL, 0.0).sum(axis=1)
        return total - float(np.log(scales).sum())

    def _centres(self, memory: RememberedCable, angles: FloatArray) -> FloatArray:
        """Return the middle of the density, for given angles, shape (N, 4).

        A cable that left lies along the border of the image, whichever way it has turned since.
        """
        centres = np.tile(memory.places, (len(angles), 1))
        if memory.side:
            along = support(angles, self.image_size) - max(self.inset(memory), 0.0)
            centres[:, StateColumn.DISTANCE] = memory.side * along
        return centres

    def inset(self, memory: RememberedCable) -> float:
        """Return how far inside the edge of the image the remembered cable was [px]."""
        return inset(memory.places, self.image_size)

    def scales(self, memory: RememberedCable) -> FloatArray:
        """Return how far from where it was the cable is looked for, shape (4,) [px, rad]."""
        scale = self.image_size[0] / REFERENCE_WIDTH
        scales = np.minimum(SPREAD + SPREADING * memory.seconds, WIDEST)
        scaled: FloatArray = scales * np.array([scale, 1.0, scale, 1.0])
        return scaled
