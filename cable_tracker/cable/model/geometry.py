"""Lines in the image: the centreline, the two borders, and how they belong together.

All angles in radians, all lengths in pixels, in the image frame: origin at the image centre, x to
the right, y up. A line is given in Hesse normal form, ``x cos(angle) + y sin(angle) = offset``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.cable.model.state import StateColumn

CABLES_AT_ONCE = 512
"""Cables measured in one go, so that it all stays in the cache and memory does not grow with N."""

SIGN_CHANGING_COLUMNS = (
    StateColumn.DISTANCE,
    StateColumn.SKEW,
    StateColumn.DISTANCE_RATE,
    StateColumn.SKEW_RATE,
)
"""Components that change their sign when the normal is turned round."""


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

    def blocks(self) -> Iterator[Borders]:
        """Go through them, at most `CABLES_AT_ONCE` at a time; without a cable, one empty block."""
        for start in range(0, max(len(self.angles), 1), CABLES_AT_ONCE):
            block = slice(start, start + CABLES_AT_ONCE)
            yield Borders(self.angles[block], self.offsets[block])


def wrap_angle(angle: FloatArray) -> FloatArray:
    """Wrap the angle of a line's normal to (-pi/2, pi/2]; any shape, any whole number of turns."""
    return np.pi / 2 - np.mod(np.pi / 2 - angle, np.pi)


def wrap_states(states: FloatArray) -> FloatArray:
    """Write each cable with its normal angle in (-pi/2, pi/2].

    (d, alpha) and (-d, alpha +- pi) are one line. Turning the normal round also exchanges the
    borders and the sense of "up the cable", so that the skew, its rate and the distance rate change
    their signs too.

    Parameters
    ----------
    states : FloatArray
        Shape (N, 8).

    Returns
    -------
    FloatArray
        Shape (N, 8), the same cables.
    """
    wrapped = wrap_angle(states[:, StateColumn.ANGLE])
    half_turns = np.rint((states[:, StateColumn.ANGLE] - wrapped) / np.pi)
    sign = np.where(np.mod(half_turns, 2.0) == 0.0, 1.0, -1.0)
    result = states.copy()
    result[:, StateColumn.ANGLE] = wrapped
    for column in SIGN_CHANGING_COLUMNS:
        result[:, column] *= sign
    return result


def wrap_state(state: FloatArray) -> FloatArray:
    """Write one cable, shape (8,), with its normal angle in (-pi/2, pi/2]; see `wrap_states`."""
    angle = float(state[StateColumn.ANGLE])
    wrapped = math.pi / 2 - (math.pi / 2 - angle) % math.pi
    result = state.copy()
    result[StateColumn.ANGLE] = wrapped
    if round((angle - wrapped) / math.pi) % 2:
        for column in SIGN_CHANGING_COLUMNS:
            result[column] = -result[column]
    return result


def unwrap_states(states: FloatArray, reference_angle: float) -> FloatArray:
    """Write each cable with its normal angle within pi/2 of a reference angle.

    In this chart the cables around the reference can be averaged like vectors, also those that lie
    on both sides of the wrap.

    Parameters
    ----------
    states : FloatArray
        Shape (N, 8).
    reference_angle : float
        Centre of the chart [rad].

    Returns
    -------
    FloatArray
        Shape (N, 8), the same cables, angles in (reference - pi/2, reference + pi/2].
    """
    shifted = states.copy()
    shifted[:, StateColumn.ANGLE] -= reference_angle
    chart = wrap_states(shifted)
    chart[:, StateColumn.ANGLE] += reference_angle
    return chart


def project_borders(states: FloatArray) -> Borders:
    """Project cables to their two borders (thesis, section 4.3.1).

    The left border has the normal angle alpha - beta and passes through f - (w/2) n, the right one
    alpha + beta and f + (w/2) n, where f is the foot point and n the normal of the centreline.

    Parameters
    ----------
    states : FloatArray
        Shape (N, 4) or more columns.
    """
    distance = states[:, StateColumn.DISTANCE]
    angle = states[:, StateColumn.ANGLE]
    half_width = states[:, StateColumn.WIDTH] / 2
    skew = states[:, StateColumn.SKEW]
    angles = np.stack((angle - skew, angle + skew), axis=1)
    cos_skew = np.cos(skew)
    offsets = np.stack(((distance - half_width) * cos_skew, (distance + half_width) * cos_skew), 1)
    return Borders(angles, offsets)


def states_from_borders(borders: Borders) -> FloatArray:
    """Return d, alpha, w, beta of cables with the given borders, shape (N, 4).

    The inverse of `project_borders`. The two normals must point the same way, from left to right,
    and be less than pi apart.
    """
    left, right = borders.angles[:, 0], borders.angles[:, 1]
    skew = (right - left) / 2
    cos_skew = np.cos(skew)
    distance = (borders.offsets[:, 0] + borders.offsets[:, 1]) / (2 * cos_skew)
    width = (borders.offsets[:, 1] - borders.offsets[:, 0]) / cos_skew
    return np.stack((distance, (left + right) / 2, width, skew), axis=1)


def foot_point(distance: float, angle: float) -> tuple[float, float]:
    """Return the point (x, y) of a line that is nearest to the image centre [px]."""
    return float(distance * np.cos(angle)), float(distance * np.sin(angle))


def sample_points(
    borders: Borders, spacing: float, image_size: tuple[int, int]
) -> tuple[FloatArray, BoolArray]:
    """Place points along each border, at equal distances from the border's own foot point.

    Parameters
    ----------
    borders : Borders
        N pairs of borders.
    spacing : float
        Distance between neighbours [px].
    image_size : (int, int)
        Width and height of the image [px].

    Returns
    -------
    points : FloatArray
        x, y in the image frame [px], shape (N, 2, M, 2); M is odd and the same for all borders.
    inside : BoolArray
        Whether the point lies inside the image, shape (N, 2, M).
    """
    width, height = image_size
    reach = int(np.hypot(width, height) / 2 / spacing)
    along = np.arange(-reach, reach + 1) * spacing
    cos, sin = np.cos(borders.angles)[..., None], np.sin(borders.angles)[..., None]
    offsets = borders.offsets[..., None]
    points = np.stack((offsets * cos - along * sin, offsets * sin + along * cos), axis=-1)
    inside = (np.abs(points[..., 0]) <= (width - 1) / 2) & (
        np.abs(points[..., 1]) <= (height - 1) / 2
    )
    return points, inside


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
    width, height = image_size
    low, high = -np.inf, np.inf
    cos, sin = np.cos(angle), np.sin(angle)
    for start, slope, limit in (
        (offset * cos, -sin, (width - 1) / 2),
        (offset * sin, cos, (height - 1) / 2),
    ):
        if abs(slope) < 1e-12:
            if abs(start) > limit:
                return None
            continue
        first, second = sorted(((-limit - start) / slope, (limit - start) / slope))
        low, high = max(low, first), min(high, second)
    if low >= high:
        return None
    return (
        (float(offset * cos - low * sin), float(offset * sin + low * cos)),
        (float(offset * cos - high * sin), float(offset * sin + high * cos)),
    )


def image_to_pixel(points: FloatArray, image_size: tuple[int, int]) -> FloatArray:
    """Turn points (..., 2) of the image frame into pixel coordinates (column, row from the top)."""
    width, height = image_size
    return np.stack(((width - 1) / 2 + points[..., 0], (height - 1) / 2 - points[..., 1]), axis=-1)
