"""Where a cable that was not followed comes from: the densities of births and of border switches.

A cable that has left over an edge of the image is looked for along that edge, one that vanished in
the middle (buried, or hidden) about where it was; the longer it is gone, the farther from there.
While no cable is known, a part of the birth density is about the strips that a map of the frame
shows (particles there come from the candidates, see `likeliest_strips`). That looks at the frame
before it counts, as births about measurements do in other trackers of several objects: spread over
all poses, a cable that is seen for the first time weighs so little that wide strips, followed since
the search began, lead for many frames.

A hypothesis often holds one border of the cable and takes a furrow, a shadow or another cable's
border for the other one. So the cable may be, with a small probability in each frame, any strip
that shares a border with the hypothesis that leads, on either side of it: a border switch.

How likely a cable comes and goes, says `cable_tracker.tracking.rates`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.geometry import (
    border_side,
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
    pose_units,
)
from cable_tracker.compilation import compiled_inside, compiled_loop
from cable_tracker.particle_filter.student_t import relative_density

BIRTH_TAIL = 4.0
"""Degrees of freedom of the Student-t of births about the remembered cable."""

BIRTH_PEAK = (
    math.gamma((BIRTH_TAIL + 1.0) / 2)
    / math.gamma(BIRTH_TAIL / 2)
    / math.sqrt(BIRTH_TAIL * math.pi)
) ** POSE_SIZE
"""Density at the middle of the births about the remembered cable, for scales of one."""

MAP_SHARE = 0.03
"""Share of the birth density about the strips of the map. Chosen on the worlds to tune on
(`tune_*`): with a half, strips that a map shows wrongly are followed too soon."""

MAP_SCALES = np.array([6.0, 0.06, 6.0, 0.06])
"""Scales of the births about a strip of the map: d, alpha, w, beta [px at the reference width,
rad]."""

MOST_TURNS = 2
"""Half turns that an angle may be drawn away from the remembered one; hardly any goes farther."""

BORDER_SWITCH_RATE = 0.7
"""Rate at which a hypothesis turns out to have one border wrong [1/s]."""

OFFSET_SIGMA, ANGLE_SIGMA, SKEW_SIGMA = 4.0, math.radians(2.0), math.radians(6.0)
"""How exactly the shared border is known [px at the reference width, rad], and how far the skew is
from that of the hypothesis [rad]."""

COMBINATIONS = 4
"""The left or the right border of the hypothesis is the left or the right one of the strip."""


class BirthDensity(NamedTuple):
    """Where a cable that was not in view comes into it: anywhere, or where one was last seen.

    Attributes
    ----------
    box : SearchBox
        The box of the search without knowledge.
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
    image_size : (float, float)
        Width and height of the frames [px].
    map_strips : FloatArray
        Strips that the map of the frame shows, shape (S, 8): none beside a known cable.
    map_scales : FloatArray
        `MAP_SCALES` for frames of this size, shape (4,) [px, rad].
    """

    box: SearchBox
    box_density: float
    pose: FloatArray
    scales: FloatArray
    share: float
    side: float
    inset: float
    peak: float
    image_size: tuple[float, float]
    map_strips: FloatArray
    map_scales: FloatArray


def births_anywhere(
    box: SearchBox, image_size: tuple[int, int], frame_scale: float
) -> BirthDensity:
    """Return the density of births in a box, without a remembered cable and without a map.

    `image_size`: width and height of the frames [px]; `frame_scale`: see `WorkingImage`.
    """
    return BirthDensity(
        box=box,
        box_density=1.0 / math.prod((box.upper - box.lower)[:POSE_SIZE].tolist()),
        pose=np.zeros(POSE_SIZE),
        scales=np.ones(POSE_SIZE),
        share=0.0,
        side=0.0,
        inset=0.0,
        peak=BIRTH_PEAK,
        image_size=(float(image_size[0]), float(image_size[1])),
        map_strips=np.empty((0, STATE_SIZE)),
        map_scales=MAP_SCALES * pose_units(frame_scale),
    )


def draw_births(births: BirthDensity, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw cables with their angle in (-pi/2, pi/2], shape (count, 8), none by the map."""
    uniform = rng.random((count, STATE_SIZE))
    about_memory = rng.standard_t(BIRTH_TAIL, (count, POSE_SIZE))
    states = np.empty((count, STATE_SIZE))
    remembered = round(births.share * count)
    place_births(states, 0, count, remembered, births, uniform, about_memory)
    return wrap_states(states)


@compiled_loop
def place_births(
    states: FloatArray, start: int, stop: int, remembered: int, births: BirthDensity,
    uniform: FloatArray, about_memory: FloatArray,
) -> None:  # fmt: skip
    """Draw births into the rows from `start` to `stop`, first those about the memory.

    `uniform` and `about_memory` as in `FrameNoise`.
    """
    for row in range(start, stop):
        if row - start < remembered:
            _place_about_memory(states[row], about_memory[row - start], births)
        else:
            for column in range(STATE_SIZE):
                states[row, column] = between(
                    births.box.lower[column], births.box.upper[column], uniform[row, column]
                )


@compiled_loop
def _place_about_memory(state: FloatArray, noise: FloatArray, births: BirthDensity) -> None:
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
    reach = image_reach(angle, births.image_size[0], births.image_size[1])
    return births.side * (reach - max(births.inset, 0.0))


@compiled_inside
def birth_density(state: FloatArray, drawn: float, births: BirthDensity) -> float:
    """Return the density of births at the pose of a state (8,); `drawn`: without the map."""
    if len(births.map_strips) == 0:
        return drawn
    return (1.0 - MAP_SHARE) * drawn + MAP_SHARE * _density_by_map(state, births)


@compiled_inside
def drawn_birth_density(state: FloatArray, births: BirthDensity) -> float:
    """Return the density that births are drawn from at the pose of a state (8,): without the map.

    About its strips particles are drawn in rounds, see `proposals`.
    """
    wrapped, sign = relative_direction(state[ANGLE], 0.0)
    lower, upper = births.box
    inside = (
        lower[DISTANCE] <= sign * state[DISTANCE] <= upper[DISTANCE]
        and lower[ANGLE] <= wrapped <= upper[ANGLE]
        and lower[WIDTH] <= state[WIDTH] <= upper[WIDTH]
        and lower[SKEW] <= sign * state[SKEW] <= upper[SKEW]
    )
    anywhere = births.box_density if inside else 0.0
    if births.share == 0.0:
        return anywhere
    return (1.0 - births.share) * anywhere + births.share * _density_about_memory(state, births)


@compiled_inside
def _density_about_memory(state: FloatArray, births: BirthDensity) -> float:
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
def _density_by_map(state: FloatArray, births: BirthDensity) -> float:
    """Return the mean of the densities about the strips of the map, of which there is one."""
    scales, near = births.map_scales, 0.0
    for strip in births.map_strips:
        wrapped, sign = relative_direction(state[ANGLE], strip[ANGLE])
        near += (
            _birth_tail((sign * state[DISTANCE] - strip[DISTANCE]) / scales[DISTANCE])
            * _birth_tail(wrapped / scales[ANGLE])
            * _birth_tail((state[WIDTH] - strip[WIDTH]) / scales[WIDTH])
            * _birth_tail((sign * state[SKEW] - strip[SKEW]) / scales[SKEW])
        )
    volume = scales[DISTANCE] * scales[ANGLE] * scales[WIDTH] * scales[SKEW]
    return float(near * BIRTH_PEAK / (len(births.map_strips) * volume))


@compiled_inside
def _beside(distance: float, skew: float, middle: float, births: BirthDensity) -> float:
    a = (distance - middle) / births.scales[DISTANCE]
    d = (skew - births.pose[SKEW]) / births.scales[SKEW]
    return _birth_tail(a) * _birth_tail(d)


@compiled_inside
def _birth_tail(deviation: float) -> float:
    return relative_density(deviation * deviation, BIRTH_TAIL, 1)


class BorderSwitch(NamedTuple):
    """Density of strips that share a border with a hypothesis.

    Attributes
    ----------
    crossings : FloatArray
        d -+ w/2: where the left and right border cross the centreline's normal through its foot
        point [px], shape (2,).
    angles : FloatArray
        alpha -+ beta: normal angles of the left and right border [rad], shape (2,).
    skew : float
        beta of the hypothesis [rad].
    narrowest, widest : float
        Limits of the widths of the strips, the first one below the other [px].
    offset_sigma : float
        `OFFSET_SIGMA` for frames of this size [px].
    """

    crossings: FloatArray
    angles: FloatArray
    skew: float
    narrowest: float
    widest: float
    offset_sigma: float


@compiled_loop
def place_switches(
    states: FloatArray, start: int, stop: int, switch: BorderSwitch,
    normal: FloatArray, uniform: FloatArray,
) -> None:  # fmt: skip
    """Draw the poses of strips into the rows from `start` to `stop`.

    `normal` and `uniform` as in `FrameNoise`.
    """
    for row in range(start, stop):
        combination = (row - start) % COMBINATIONS
        shared, side = combination // 2, border_side(combination % 2)
        offset = switch.crossings[shared] + switch.offset_sigma * normal[row, DISTANCE]
        angle = switch.angles[shared] + ANGLE_SIGMA * normal[row, ANGLE]
        ratio = switch.widest / switch.narrowest
        width = switch.narrowest * math.pow(ratio, uniform[row, WIDTH])
        skew = switch.skew + SKEW_SIGMA * normal[row, SKEW]
        states[row, DISTANCE] = offset - 0.5 * side * width
        states[row, ANGLE] = angle - side * skew
        states[row, WIDTH] = width
        states[row, SKEW] = skew


@compiled_inside
def switch_density(state: FloatArray, switch: BorderSwitch) -> float:
    """Return the density of border switches at d, alpha, w, beta of a state."""
    width = state[WIDTH]
    if not switch.narrowest <= width <= switch.widest:
        return 0.0
    total = 0.0
    turn = (state[SKEW] - switch.skew) / SKEW_SIGMA
    for combination in range(COMBINATIONS):
        shared, side = combination // 2, border_side(combination % 2)
        a = (state[DISTANCE] + 0.5 * side * width - switch.crossings[shared]) / switch.offset_sigma
        b = (state[ANGLE] + side * state[SKEW] - switch.angles[shared]) / ANGLE_SIGMA
        squared = a * a + b * b + turn * turn
        if squared < 50.0:
            total += math.exp(-0.5 * squared)
    scales = switch.offset_sigma * ANGLE_SIGMA * SKEW_SIGMA * math.pow(2.0 * math.pi, 1.5)
    log_range = math.log(switch.widest / switch.narrowest)
    return float(total / (COMBINATIONS * scales * width * log_range))
