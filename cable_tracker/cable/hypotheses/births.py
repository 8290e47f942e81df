"""Where a cable that was not in view comes into it: the density of births.

A cable that has left over an edge of the image is looked for along that edge, one that vanished in
the middle (buried, or hidden) about where it was; the longer it is gone, the farther from there.
How likely one comes and goes, says `cable_tracker.tracking.survival`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.hypotheses.frame_noise import ALIKE, BIRTH_TAIL, FrameNoise
from cable_tracker.cable.hypotheses.remembered_cable import RememberedCable
from cable_tracker.cable.model.geometry import (
    image_reach,
    relative_direction,
    wrap_states,
)
from cable_tracker.cable.model.initial_state import SearchBox, between
from cable_tracker.cable.model.state import (
    ANGLE,
    DISTANCE,
    POSE_SIZE,
    SKEW,
    STATE_SIZE,
    WIDTH,
)
from cable_tracker.compilation import compiled_inside, compiled_loop
from cable_tracker.particle_filter.student_t import relative_density
from cable_tracker.tracking.survival import share_about_last_place

BIRTH_PEAK = (
    math.gamma((BIRTH_TAIL + 1.0) / 2)
    / math.gamma(BIRTH_TAIL / 2)
    / math.sqrt(BIRTH_TAIL * math.pi)
) ** POSE_SIZE
"""Density at the middle of the births about the remembered cable, for scales of one."""

MOST_TURNS = 2
"""Half turns that an angle may be drawn away from the remembered one; hardly any goes farther."""


class BirthDensity(NamedTuple):
    """Where a cable that was not in view comes into it: anywhere, or where one was last seen.

    Attributes
    ----------
    lower, upper : FloatArray
        The box of the search without knowledge, shape (8,) [px, rad, per second].
    box_density : float
        Density of d, alpha, w, beta in it.
    pose, scales : FloatArray
        The remembered cable, and the scales of births about it, shape (4,).
    share : float
        Share of the births about the remembered cable; 0 without one.
    side, inset : float
        Sign of d where it left over the edge, else 0; how far inside it was then [px].
    peak : float
        Density of the births about the remembered cable, at their middle.
    width, height : float
        Size of the frames [px].
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
        Box of the births that are not about the remembered cable.
    memory : RememberedCable or None
        Cable that was tracked before.
    memory_time : float
        Time constant of the share of births about the remembered cable [s].
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
        inset=memory.inset if memory is not None else 0.0,
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


@compiled_loop
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
                states[row, column] = between(
                    births.lower[column], births.upper[column], noise.uniform[row, column]
                )


@compiled_loop
def _place_near(state: FloatArray, noise: FloatArray, births: BirthDensity) -> None:
    angle = births.pose[ANGLE] + noise[ANGLE] * births.scales[ANGLE]
    state[DISTANCE] = _middle_at(angle, births) + noise[DISTANCE] * births.scales[DISTANCE]
    state[ANGLE] = angle
    state[WIDTH] = births.pose[WIDTH] + noise[WIDTH] * births.scales[WIDTH]
    state[SKEW] = births.pose[SKEW] + noise[SKEW] * births.scales[SKEW]
    for column in range(POSE_SIZE, STATE_SIZE):
        state[column] = 0.0


@compiled_inside
def _middle_at(angle: float, births: BirthDensity) -> float:
    """Return the d about which a remembered cable is looked for, for an angle."""
    if births.side == 0.0:
        return float(births.pose[DISTANCE])
    reach = image_reach(angle, births.width, births.height)
    return births.side * (reach - max(births.inset, 0.0))


@compiled_inside
def birth_density(state: FloatArray, births: BirthDensity) -> float:
    """Return the density of births at the places of a state (8,)."""
    wrapped, sign = relative_direction(state[ANGLE], 0.0)
    lower, upper = births.lower, births.upper
    inside = (
        lower[DISTANCE] <= sign * state[DISTANCE] <= upper[DISTANCE]
        and lower[ANGLE] <= wrapped <= upper[ANGLE]
        and lower[WIDTH] <= state[WIDTH] <= upper[WIDTH]
        and lower[SKEW] <= sign * state[SKEW] <= upper[SKEW]
    )
    anywhere = births.box_density if inside else 0.0
    if births.share == 0.0:
        return anywhere
    return (1.0 - births.share) * anywhere + births.share * _density_near(state, births)


@compiled_inside
def _density_near(state: FloatArray, births: BirthDensity) -> float:
    """Return the density about the memory, over all half turns that the angle may have made."""
    wrapped, turned = relative_direction(state[ANGLE], births.pose[ANGLE])
    # A half turn changes the signs of d and beta, and nothing else.
    middle = _middle_at(wrapped + births.pose[ANGLE], births)
    scales = births.scales
    width = (state[WIDTH] - births.pose[WIDTH]) / scales[WIDTH]
    as_it_is = _beside(turned * state[DISTANCE], turned * state[SKEW], middle, births)
    turned_round = _beside(-turned * state[DISTANCE], -turned * state[SKEW], middle, births)
    near = 0.0
    for turn in range(-MOST_TURNS, MOST_TURNS + 1):
        beside = as_it_is if turn % 2 == 0 else turned_round
        near += beside * _birth_tail((wrapped + turn * math.pi) / scales[ANGLE])
    return near * _birth_tail(width) * births.peak


@compiled_inside
def _beside(distance: float, skew: float, middle: float, births: BirthDensity) -> float:
    a = (distance - middle) / births.scales[DISTANCE]
    d = (skew - births.pose[SKEW]) / births.scales[SKEW]
    return _birth_tail(a) * _birth_tail(d)


@compiled_inside
def _birth_tail(deviation: float) -> float:
    return relative_density(deviation * deviation, BIRTH_TAIL, 1)
