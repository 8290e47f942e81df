"""How a cable leaves the image, and where to look for it then.

Whether it is in view is a Markov chain, see `cable_tracker.tracking.survival`. A cable that has
left is looked for along the border over which it went, one that vanished in the middle (buried, or
hidden) about where it was; the longer it is gone, the farther from there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.frame_noise import ALIKE, BIRTH_TAIL, FrameNoise
from cable_tracker.cable.model.geometry import reach_at, turn_sign, wrap_states, wrapped_angle
from cable_tracker.cable.model.initialisation import SearchBox
from cable_tracker.cable.model.state import POSE_SIZE, STATE_SIZE, StateColumn
from cable_tracker.cable.parameters.parameters import REFERENCE_WIDTH, TrackerParameters
from cable_tracker.compilation import compiled, compiled_inside, compiled_loop
from cable_tracker.tracking.survival import SurvivalRates, share_about_last_place

SPREAD = np.array([4.0, math.radians(2.0), 3.0, math.radians(1.0)])
"""How far from where it was a cable is looked for at once: d, alpha, w, beta [px at the reference
width, rad]."""

SPREADING = np.array([100.0, math.radians(37.0), 50.0, math.radians(7.5)])
"""How much farther after every second [px/s at the reference width, rad/s]."""

WIDEST = np.array([120.0, math.radians(60.0), 40.0, math.radians(10.0)])
"""Largest spread about the last place; a cable farther away is found by the uninformed search."""

BIRTH_PEAK = (
    math.gamma((BIRTH_TAIL + 1.0) / 2)
    / math.gamma(BIRTH_TAIL / 2)
    / math.sqrt(BIRTH_TAIL * math.pi)
) ** POSE_SIZE
"""Density at the middle of the births about the remembered cable, for scales of one."""

MOST_TURNS = 2
"""Half turns that an angle may be drawn away from the remembered one; hardly any goes farther."""

LEFT_MARGIN = 3.0
"""A cable was leaving if it was nearer to the edge than this many `leaving_margin`."""


def survival_rates(parameters: TrackerParameters, image_width: int) -> SurvivalRates:
    """Return how often a cable leaves frames of a given width [px]."""
    return SurvivalRates(
        vanishing=parameters.disappearance_rate,
        leaving=parameters.leaving_rate,
        margin=parameters.leaving_margin * image_width / REFERENCE_WIDTH,
    )


def inset(state: FloatArray, image_size: tuple[int, int]) -> float:
    """Return how far one centreline, shape (4,) or more, is from leaving the image [px]."""
    angle, distance = float(state[StateColumn.ANGLE]), float(state[StateColumn.DISTANCE])
    width, height = image_size
    return reach_at(angle, float(width), float(height)) - abs(distance)


@dataclass(frozen=True, slots=True, eq=False)
class RememberedCable:
    """Where a cable was when it was last tracked.

    Attributes
    ----------
    pose : FloatArray
        d, alpha, w, beta, shape (4,) [px, rad].
    side : float
        Sign of d if it was leaving the image there; 0 if it was not.
    seconds : float
        How long ago that was [s].
    """

    pose: FloatArray
    side: float
    seconds: float = 0.0

    def aged(self, dt: float) -> RememberedCable:
        """Return the same memory `dt` seconds later."""
        return replace(self, seconds=self.seconds + dt)

    def scales(self, image_width: int) -> FloatArray:
        """Return how far from there the cable is looked for, shape (4,) [px, rad]."""
        scale = image_width / REFERENCE_WIDTH
        scales = np.minimum(SPREAD + SPREADING * self.seconds, WIDEST)
        scaled: FloatArray = scales * np.array([scale, 1.0, scale, 1.0])
        return scaled


def remember(
    state: FloatArray, image_size: tuple[int, int], parameters: TrackerParameters
) -> RememberedCable:
    """Return the memory of a cable, shape (8,), that is tracked now."""
    margin = LEFT_MARGIN * parameters.leaving_margin * image_size[0] / REFERENCE_WIDTH
    leaving = inset(state, image_size) < margin
    side = float(np.sign(state[StateColumn.DISTANCE])) if leaving else 0.0
    return RememberedCable(state[:POSE_SIZE].copy(), side)


class BirthDensity(NamedTuple):
    """Where a cable that was not in view comes into it: anywhere, or where one was last seen.

    Attributes
    ----------
    lower, upper : FloatArray
        The box of the search without knowledge, shape (8,) [px, rad, per second].
    box_density : float
        Density of d, alpha, w, beta in it.
    pose, scales : FloatArray
        The remembered cable, and how far from there it is looked for, shape (4,).
    share : float
        Share of the births about the remembered cable; 0 without one.
    side, inset : float
        Sign of d where it left over the edge, else 0; how far inside it was then [px].
    peak : float
        Density of the births about the remembered cable, at their middle.
    width, height : float
        Of the frames [px].
    """

    lower: FloatArray
    upper: FloatArray
    box_density: float
    pose: FloatArray
    scales: FloatArray
    share: float
    side: float
    inset: float
    peak: float
    width: float
    height: float

    def remembered_of(self, count: int) -> int:
        """Return how many of `count` births are about the remembered cable."""
        return round(self.share * count)


def birth_density_of(
    box: SearchBox,
    memory: RememberedCable | None,
    memory_time: float,
    image_size: tuple[int, int],
) -> BirthDensity:
    """Return the density of births.

    Parameters
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
    scales = memory.scales(image_size[0]) if memory is not None else np.ones(POSE_SIZE)
    return BirthDensity(
        lower=box.lower,
        upper=box.upper,
        box_density=1.0 / math.prod((box.upper - box.lower)[:POSE_SIZE].tolist()),
        pose=memory.pose if memory is not None else np.zeros(POSE_SIZE),
        scales=scales,
        share=share_about_last_place(memory.seconds, memory_time) if memory is not None else 0.0,
        side=memory.side if memory is not None else 0.0,
        inset=inset(memory.pose, image_size) if memory is not None else 0.0,
        peak=BIRTH_PEAK / math.prod(scales.tolist()),
        width=float(image_size[0]),
        height=float(image_size[1]),
    )


def draw_births(births: BirthDensity, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw cables with their angle in (-pi/2, pi/2], shape (count, 8)."""
    noise = FrameNoise(
        np.empty((0, STATE_SIZE)),
        np.empty((0, 2)),
        rng.random((count, STATE_SIZE)),
        rng.standard_t(BIRTH_TAIL, (count, POSE_SIZE)),
        np.empty((0, POSE_SIZE)),
        np.empty(0),
        np.empty((0, ALIKE)),
    )
    states = np.empty((count, STATE_SIZE))
    place_births(states, 0, count, births.remembered_of(count), births, noise)
    return wrap_states(states)


@compiled
def place_births(
    states: FloatArray, start: int, stop: int, remembered: int, births: BirthDensity,
    noise: FrameNoise,
) -> None:  # fmt: skip
    """Draw births into the rows from `start` to `stop`, first those about the memory."""
    for row in range(start, stop):
        if row - start < remembered:
            _place_near(states[row], noise.about_memory[row - start], births)
        else:
            for column in range(STATE_SIZE):
                states[row, column] = births.lower[column] + noise.uniform[row, column] * (
                    births.upper[column] - births.lower[column]
                )


@compiled_loop
def _place_near(state: FloatArray, noise: FloatArray, births: BirthDensity) -> None:
    angle = births.pose[1] + noise[1] * births.scales[1]
    state[0] = _middle_at(angle, births) + noise[0] * births.scales[0]
    state[1] = angle
    state[2] = births.pose[2] + noise[2] * births.scales[2]
    state[3] = births.pose[3] + noise[3] * births.scales[3]
    for column in range(POSE_SIZE, STATE_SIZE):
        state[column] = 0.0


@compiled_inside
def _middle_at(angle: float, births: BirthDensity) -> float:
    """Return the d about which a remembered cable is looked for, for an angle."""
    if births.side == 0.0:
        return float(births.pose[0])
    reach = reach_at(angle, births.width, births.height)
    return births.side * (reach - max(births.inset, 0.0))


@compiled_inside
def birth_density(state: FloatArray, births: BirthDensity) -> float:
    """Return the density of births at the places of a state (8,)."""
    wrapped = wrapped_angle(state[1])
    sign = turn_sign(state[1], wrapped)
    inside = (
        births.lower[0] <= sign * state[0] <= births.upper[0]
        and births.lower[1] <= wrapped <= births.upper[1]
        and births.lower[2] <= state[2] <= births.upper[2]
        and births.lower[3] <= sign * state[3] <= births.upper[3]
    )
    anywhere = births.box_density if inside else 0.0
    if births.share == 0.0:
        return anywhere
    return (1.0 - births.share) * anywhere + births.share * _density_near(state, births)


@compiled_inside
def _density_near(state: FloatArray, births: BirthDensity) -> float:
    """Return the density about the memory, over all half turns that the angle may have made."""
    shifted = state[1] - births.pose[1]
    wrapped = wrapped_angle(shifted)
    turned = turn_sign(shifted, wrapped)
    # A half turn changes the signs of d and beta, and nothing else.
    middle = _middle_at(wrapped + births.pose[1], births)
    scales = births.scales
    width = (state[2] - births.pose[2]) / scales[2]
    as_it_is = _beside(turned * state[0], turned * state[3], middle, births)
    turned_round = _beside(-turned * state[0], -turned * state[3], middle, births)
    near = 0.0
    for turn in range(-MOST_TURNS, MOST_TURNS + 1):
        beside = as_it_is if turn % 2 == 0 else turned_round
        near += beside * _birth_tail((wrapped + turn * math.pi) / scales[1])
    return near * _birth_tail(width) * births.peak


@compiled_inside
def _beside(distance: float, skew: float, middle: float, births: BirthDensity) -> float:
    a = (distance - middle) / births.scales[0]
    d = (skew - births.pose[3]) / births.scales[3]
    return _birth_tail(a) * _birth_tail(d)


@compiled_inside
def _birth_tail(deviation: float) -> float:
    base = 1.0 + deviation * deviation / BIRTH_TAIL
    if BIRTH_TAIL == 4.0:
        return 1.0 / (base * base * math.sqrt(base))
    return math.pow(base, -0.5 * (BIRTH_TAIL + 1.0))
