"""Lines in the image: the centreline, the two borders, and how they belong together.

All angles in radians, all lengths in pixels, in the image frame: origin at the image centre, x to
the right, y up. A line is given in Hesse normal form, ``x cos(angle) + y sin(angle) = offset``.

(d, alpha) and (-d, alpha +- pi) are one line. A *chart* about a reference angle is the way to write
cables with alpha within pi/2 of that angle: in it nearby cables have nearby numbers, so that they
can be compared and averaged as vectors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.cable.model.state import (
    ANGLE,
    ANGLE_RATE,
    DISTANCE,
    DISTANCE_RATE,
    POSE_SIZE,
    SKEW,
    SKEW_RATE,
    STATE_SIZE,
    WIDTH,
    WIDTH_RATE,
    CableState,
)
from cable_tracker.compilation import compiled, compiled_inside

Number = TypeVar("Number", float, FloatArray)

TURNED_SIGNS: FloatArray = np.array([-1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0, -1.0])
"""Factors of the components of a state whose normal is turned round: d, beta and their rates."""

LEAST_SLOPE = 1e-12
"""A line that comes nearer to a side of the image by less, over a pixel, never meets it [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class Borders:
    """The two borders of each of N cables.

    Attributes
    ----------
    angles : FloatArray
        Normal angles [rad], shape (N, 2): left, right.
    offsets : FloatArray
        Signed distances from the image centre [px], shape (N, 2): left, right.
    """

    angles: FloatArray
    offsets: FloatArray


def wrap_angles(angles: FloatArray) -> FloatArray:
    """Wrap angles of lines' normals to (-pi/2, pi/2]; any shape, any whole number of turns."""
    wrapped = angles - math.pi * np.rint(angles / math.pi)
    # Rounding may leave it on the wrong side of either end.
    wrapped = np.where(wrapped <= -math.pi / 2, wrapped + math.pi, wrapped)
    return np.where(wrapped > math.pi / 2, wrapped - math.pi, wrapped)


@compiled_inside
def wrap_angle(angle: float) -> float:
    """Wrap the angle of a normal to (-pi/2, pi/2]; `wrap_angles` for a single one, in kernels."""
    # Without the remainder of a division, which takes longer than all the rest.
    wrapped: float = angle - math.pi * np.rint(angle / math.pi)
    if wrapped <= -math.pi / 2:
        return wrapped + math.pi
    return wrapped - math.pi if wrapped > math.pi / 2 else wrapped


def wraps_between(angles: FloatArray) -> BoolArray:
    """Tell between which angles of a series, shape (N,), the wrap lies; shape (N - 1,).

    No cable makes more than a quarter turn between two frames. d and beta change their signs there.
    """
    return np.asarray(np.abs(np.diff(angles)) > math.pi / 2)


SMALLEST_SKEW = 1e-6
"""Borders that are turned by less against the centreline are parallel [rad]."""

TIP_MARGIN = 0.15
"""How far inwards of the picture's edges the borders of a cable may meet, as a share of its width
or height: where a camera looks ahead, a cable vanishes in the distance. Chosen, as are the two that
follow, on the simulated worlds to tune on (`tune_*`) and on S1 to S6."""

MOST_TIP_SKEW, LEAST_BEFORE_TIP = math.radians(7.0), 0.3
"""Largest skew of such a cable [rad], and smallest distance of its tip from its foot point, as a
share of the picture's smaller side: a wedge in a corner is none."""


@compiled_inside
def borders_cross_inside(pose: FloatArray, image_size: tuple[float, float]) -> bool:
    """Tell whether the borders of d, alpha, w, beta meet inside a picture: then it is no cable.

    But for one that vanishes in the distance, see `TIP_MARGIN`.
    """
    skew = abs(pose[SKEW])
    if skew < SMALLEST_SKEW:
        return False
    along = math.copysign(0.5 * pose[WIDTH] / math.tan(skew), pose[SKEW])
    cos, sin = math.cos(pose[ANGLE]), math.sin(pose[ANGLE])
    x, y = pose[DISTANCE] * cos - along * sin, pose[DISTANCE] * sin + along * cos
    vanishes = skew <= MOST_TIP_SKEW and abs(along) >= LEAST_BEFORE_TIP * min(image_size)
    reach = 0.5 - TIP_MARGIN if vanishes else 0.5
    return bool(abs(x) < reach * image_size[0] and abs(y) < reach * image_size[1])


@compiled_inside
def turn_sign(angle: float, wrapped: float) -> float:
    """Return -1 if an odd number of half turns lies between two ways of writing it, else 1."""
    turns = 0.5 * np.rint((angle - wrapped) / math.pi)
    sign: float = 1.0 - 4.0 * (turns - np.floor(turns))
    return sign


@compiled_inside
def relative_direction(angle: float, reference: float) -> tuple[float, float]:
    """Return how the normal of a line lies to a reference direction [rad].

    Returns
    -------
    (float, float)
        Difference angle - reference, wrapped to (-pi/2, pi/2]; sign of d and beta as the line is
        written with that angle: -1 if the normal is turned round for it, else 1.
    """
    shifted = angle - reference
    wrapped = wrap_angle(shifted)
    return wrapped, turn_sign(shifted, wrapped)


@compiled_inside
def pose_in_chart(pose: FloatArray, reference_angle: float, result: FloatArray) -> float:
    """Fill in the way to write d, alpha, w, beta whose normal is within pi/2 of an angle [rad].

    (d, alpha) and (-d, alpha +- pi) are one line. Turning the normal round also exchanges the
    borders and the sense of "up the cable", so that the skew changes its sign too. Returns the
    sign: -1 if the normal was turned round. `result` may be `pose`.
    """
    wrapped, sign = relative_direction(pose[ANGLE], reference_angle)
    result[DISTANCE] = sign * pose[DISTANCE]
    result[ANGLE] = wrapped + reference_angle
    result[WIDTH] = pose[WIDTH]
    result[SKEW] = sign * pose[SKEW]
    return sign


@compiled_inside
def state_in_chart(state: FloatArray, reference_angle: float, result: FloatArray) -> None:
    """Fill in the same for a cable (8,); the rates change their signs as what they change does."""
    sign = pose_in_chart(state, reference_angle, result)
    result[DISTANCE_RATE] = sign * state[DISTANCE_RATE]
    result[ANGLE_RATE] = state[ANGLE_RATE]
    result[WIDTH_RATE] = state[WIDTH_RATE]
    result[SKEW_RATE] = sign * state[SKEW_RATE]


@compiled
def write_in_chart(states: FloatArray, reference_angles: FloatArray) -> None:
    """Write cables (N, 8) with their normal angles within pi/2 of reference angles (N,) [rad]."""
    for row in range(len(states)):
        state_in_chart(states[row], reference_angles[row], states[row])


def states_in_chart(states: FloatArray, reference_angle: float | FloatArray) -> FloatArray:
    """Write each cable with its normal angle within pi/2 of a reference angle.

    In this chart the cables around the reference can be averaged like vectors, also those that lie
    on both sides of the wrap; see `state_in_chart`.

    Parameters
    ----------
    states : FloatArray
        Shape (N, 8).
    reference_angle : float or FloatArray
        Centre of the chart, or of a chart for each, shape (N,) [rad].

    Returns
    -------
    FloatArray
        Shape (N, 8), the same cables, angles in (reference - pi/2, reference + pi/2].

    Raises
    ------
    ValueError
        The states have another shape: compiled code would write beyond their end.
    """
    # Copies of one kind of array, whatever comes in: for every kind, Numba compiles anew.
    chart = np.array(states, np.float64, order="C")
    if chart.ndim != 2 or chart.shape[1] != STATE_SIZE:
        raise ValueError(f"states must have shape (N, {STATE_SIZE}), not {chart.shape}")
    write_in_chart(chart, np.full(len(chart), reference_angle, np.float64))
    return chart


def wrap_states(states: FloatArray) -> FloatArray:
    """Write each cable, shape (N, 8), with its normal angle in (-pi/2, pi/2]."""
    return states_in_chart(states, 0.0)


def wrap_state(state: FloatArray, reference_angle: float = 0.0) -> FloatArray:
    """Write one cable, shape (8,), with its normal angle within pi/2 of a reference angle.

    One that has it there stays as it is, bit for bit.
    """
    if -math.pi / 2 < state[ANGLE] - reference_angle <= math.pi / 2:
        return state.copy()
    wrapped: FloatArray = states_in_chart(state[None, :], reference_angle)[0]
    return wrapped


def wrapped_cable(state: CableState) -> CableState:
    """Return the same cable with its normal angle in (-pi/2, pi/2]."""
    return CableState.from_array(wrap_state(state.to_array()))


def wrapped_estimate(
    mean: FloatArray, covariance: FloatArray, reference_angle: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Write an estimate, shapes (8,) and (8, 8), with its normal angle within pi/2 of another."""
    wrapped = wrap_state(mean, reference_angle)
    half_turns = round(float(mean[ANGLE] - wrapped[ANGLE]) / math.pi)
    return wrapped, _turned_covariance(covariance) if half_turns % 2 else covariance


def _turned_covariance(covariance: FloatArray) -> FloatArray:
    """Return the covariance (8, 8) of a cable whose normal is turned round."""
    turned: FloatArray = covariance * np.outer(TURNED_SIGNS, TURNED_SIGNS)
    return turned


def project_borders(states: FloatArray) -> Borders:
    """Project cables to their two borders (thesis, section 4.3.1).

    The left border has the normal angle alpha - beta and passes through f - (w/2) n, the right one
    alpha + beta and f + (w/2) n, where f is the foot point and n the normal of the centreline.

    Parameters
    ----------
    states : FloatArray
        Shape (N, 4) or more columns.
    """
    distance, angle, width, skew = states[:, :POSE_SIZE].T
    angles = np.stack((angle - skew, angle + skew), axis=1)
    offsets = [border_offset(distance, width, skew, side) for side in (-1.0, 1.0)]
    return Borders(angles, np.stack(offsets, axis=1))


@compiled_inside
def border_side(index: int) -> float:
    """Return -1 for border 0, the left one, and +1 for border 1, the right one."""
    return 2.0 * index - 1.0


@compiled_inside
def border_offset(distance: Number, width: Number, skew: Number, side: float) -> Number:
    """Return the offset of a border in Hesse normal form [px]; `side`: -1 left, 1 right.

    That is its distance from the image centre along its own normal, (d -+ w/2) cos(beta), not where
    it crosses the centreline's normal.
    """
    offset: Number = (distance + side * (0.5 * width)) * np.cos(skew)
    return offset


def states_from_borders(borders: Borders) -> FloatArray:
    """Return d, alpha, w, beta of cables with the given borders, shape (N, 4).

    The inverse of `project_borders`. The two normals must point the same way, from left to right,
    and be less than pi apart.
    """
    return np.stack(pose_between(*borders.angles.T, *borders.offsets.T), axis=1)


@compiled_inside
def pose_between(
    left_angle: Number, right_angle: Number, left_offset: Number, right_offset: Number
) -> tuple[Number, Number, Number, Number]:
    """Return d, alpha, w, beta of the cable between two lines, see `states_from_borders`."""
    skew = (right_angle - left_angle) / 2
    cos_skew = np.cos(skew)
    distance = (left_offset + right_offset) / (2 * cos_skew)
    width = (right_offset - left_offset) / cos_skew
    return distance, (left_angle + right_angle) / 2, width, skew


def foot_point(distance: float, angle: float) -> tuple[float, float]:
    """Return the point (x, y) of a line that is nearest to the image centre [px]."""
    return float(distance * np.cos(angle)), float(distance * np.sin(angle))


def points_on_lines(angles: FloatArray, offsets: FloatArray, along: FloatArray) -> FloatArray:
    """Return points of lines at places along them.

    Parameters
    ----------
    angles, offsets : FloatArray
        Of the lines [rad, px], of one shape (...).
    along : FloatArray
        Places, counted from a line's foot point in its upward direction (-sin, cos) [px], shape
        (K,).

    Returns
    -------
    FloatArray
        x, y in the image frame [px], shape (..., K, 2).
    """
    cos, sin = np.cos(angles)[..., None], np.sin(angles)[..., None]
    rho = offsets[..., None]
    return np.stack((rho * cos - along * sin, rho * sin + along * cos), axis=-1)


def segment_inside(
    angle: float, offset: float, image_size: tuple[int, int]
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Clip a line to the image.

    Returns
    -------
    ((x, y), (x, y)) or None
        Lower and upper end in the image frame [px], lower in the sense of the line's own upward
        direction (-sin, cos); None if the line does not cross the image.
    """
    (low,), (high,) = _limits_inside(np.array([angle]), np.array([offset]), image_size)
    if low >= high:
        return None
    cos, sin = np.cos(angle), np.sin(angle)
    return (
        (float(offset * cos - low * sin), float(offset * sin + low * cos)),
        (float(offset * cos - high * sin), float(offset * sin + high * cos)),
    )


def middle_inside(angle: float, offset: float, image_size: tuple[int, int]) -> FloatArray | None:
    """Return the middle of what of a line lies inside the image, shape (2,); None if it misses it.

    The arguments are those of `segment_inside`.
    """
    ends = segment_inside(angle, offset, image_size)
    return None if ends is None else np.mean(ends, axis=0)


def lengths_inside(
    angles: FloatArray, offsets: FloatArray, image_size: tuple[int, int]
) -> FloatArray:
    """Return the lengths of lines (N,) inside the image [px], (N,); 0 for one that misses it."""
    low, high = _limits_inside(angles, offsets, image_size)
    return np.maximum(high - low, 0.0)


def _limits_inside(
    angles: FloatArray, offsets: FloatArray, image_size: tuple[int, int]
) -> tuple[FloatArray, FloatArray]:
    """Return from where to where lines (N,) are inside the image, along (-sin, cos), (N,) each.

    Counted from the foot point [px]. Of a line that misses the image the first is not smaller.
    """
    cos, sin = np.cos(angles), np.sin(angles)
    starts, slopes = np.stack((offsets * cos, offsets * sin)), np.stack((-sin, cos))
    limits = (np.array(image_size)[:, None] - 1) / 2
    is_parallel = np.abs(slopes) < LEAST_SLOPE
    slopes = np.where(is_parallel, 1.0, slopes)
    ends = np.sort(((-limits - starts) / slopes, (limits - starts) / slopes), axis=0)
    # Between two sides that it never meets, a line is all the way or nowhere.
    whole = np.where(np.abs(starts) <= limits, -np.inf, np.inf)
    low: FloatArray = np.where(is_parallel, whole, ends[0]).max(axis=0)
    high: FloatArray = np.where(is_parallel, np.inf, ends[1]).min(axis=0)
    return low, high


def image_reaches(angles: FloatArray, image_size: tuple[int, int]) -> FloatArray:
    """Return the largest |d| at which lines still meet the image [px], of the angles' shape."""
    width, height = image_size
    reach: FloatArray = (np.abs(np.cos(angles)) * width + np.abs(np.sin(angles)) * height) / 2
    return reach


@compiled_inside
def image_reach(angle: float, width: float, height: float) -> float:
    """Return the largest |d| at which a line still meets an image, in kernels; `image_reaches`."""
    return (abs(math.cos(angle)) * width + abs(math.sin(angle)) * height) / 2


@compiled_inside
def inset(state: FloatArray, width: float, height: float) -> float:
    """Return how far one centreline, shape (4,) or more, is from leaving the image [px]."""
    return float(image_reach(state[ANGLE], width, height) - abs(state[DISTANCE]))
