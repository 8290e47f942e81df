"""Last known line of the cable in the frame of the vehicle's odometry."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from cable_tracker.example_controller.line_of_sight import CableLine

REMEMBERED = 5.0
"""Distance travelled over which observations are kept [m]."""

FEWEST = 5
"""Observations needed for a line."""

BENT_FROM = 2.0
"""Shortest stretch of observations over which curvature is fitted [m]."""

BEND_LASTS = 5.0
"""Length over which a bend is extrapolated; beyond it the cable runs straight on [m]."""

MOST_CURVATURE = 0.08
"""[1/m]."""

DOUBTFUL = 0.3
"""Last stretch, without weight in the first fit, for the cable may disappear there [m]."""

USUAL_ERROR = 0.03
"""Scale of the residuals of the robust fit [m]."""

REWEIGHTINGS = 4

LEAST_COSINE = 0.1
"""Lower bound of the cosine of a line's heading in its offset from the vehicle."""


@dataclass(frozen=True, slots=True)
class Pose:
    """Pose of the vehicle in the frame odom.

    Attributes
    ----------
    x, y : float
        [m].
    yaw : float
        [rad].
    """

    x: float
    y: float
    yaw: float


@dataclass(frozen=True, slots=True)
class RememberedLine:
    """Extrapolated line of the cable, in the frame odom.

    Attributes
    ----------
    x, y : float
        A point of the line [m].
    direction : float
        Direction at that point [rad].
    curvature : float
        To the left positive, for a while before and behind that point [1/m].
    """

    x: float
    y: float
    direction: float
    curvature: float = 0.0

    def progress(self, pose: Pose) -> float:
        """Return the position of the vehicle along the line, from its point [m]."""
        cos, sin = math.cos(self.direction), math.sin(self.direction)
        return (pose.x - self.x) * cos + (pose.y - self.y) * sin

    def relative_to(self, pose: Pose, shift: float = 0.0) -> CableLine:
        """Return offset and heading of the line from a pose, shifted to its left by `shift` [m]."""
        cos, sin = math.cos(self.direction), math.sin(self.direction)
        along = self.progress(pose)
        across = (pose.y - self.y) * cos - (pose.x - self.x) * sin
        bent = min(max(along, -REMEMBERED), BEND_LASTS)
        slope = self.curvature * bent
        bend = slope * (along - bent / 2)
        heading = math.remainder(self.direction + math.atan(slope) - pose.yaw, 2 * math.pi)
        left = shift + (bend - across) * math.cos(math.atan(slope))
        return CableLine(_offset_at_vehicle(left, heading), heading)


def _offset_at_vehicle(left: float, heading: float) -> float:
    """Return y of a line at x = 0 in the vehicle's frame, from its distance to its own left [m].

    Beyond a right angle what is to the left of the line is to the right of the vehicle.
    """
    cos = math.cos(heading)
    return left / math.copysign(max(abs(cos), LEAST_COSINE), cos)


def line_of(cable: CableLine, pose: Pose) -> RememberedLine:
    """Return the straight line in odom of a cable that was observed from a pose."""
    x = pose.x - cable.offset * math.sin(pose.yaw)
    y = pose.y + cable.offset * math.cos(pose.yaw)
    return RememberedLine(x, y, pose.yaw + cable.heading)


@dataclass(frozen=True, slots=True)
class _Observation:
    x: float
    y: float
    direction: float
    vehicle: tuple[float, float]


LEAST_WAY = 0.01
"""Shortest distance from one remembered observation to the next but one [m]."""


class CableMemory:
    """Observations of the cable over the last metres, with a robust line through them."""

    def __init__(self) -> None:
        self._observations: deque[_Observation] = deque()

    def add(self, cable: CableLine, pose: Pose) -> None:
        """Add an observation of the cable from a pose."""
        line = line_of(cable, pose)
        place = (pose.x, pose.y)
        if (
            len(self._observations) > 1
            and math.dist(self._observations[-2].vehicle, place) < LEAST_WAY
        ):
            # A vehicle that hovers keeps the newest observation alone.
            self._observations.pop()
        self._observations.append(_Observation(line.x, line.y, line.direction, place))
        while math.dist(self._observations[0].vehicle, place) > REMEMBERED:
            self._observations.popleft()

    @property
    def way(self) -> float:
        """Distance between the vehicle's positions at the first and the last observation [m]."""
        if not self._observations:
            return 0.0
        return math.dist(self._observations[0].vehicle, self._observations[-1].vehicle)

    def line(self) -> RememberedLine | None:
        """Return the line fitted to the observations; None if they are too few.

        While the cable disappears under sand, the last observations may be off: they must not turn
        the line away.
        """
        if len(self._observations) < FEWEST:
            return None
        straight = self._straight_line()
        cos, sin = math.cos(straight.direction), math.sin(straight.direction)
        x = np.array([each.x - straight.x for each in self._observations])
        y = np.array([each.y - straight.y for each in self._observations])
        along, across = x * cos + y * sin, y * cos - x * sin
        if np.ptp(along) < BENT_FROM:
            return straight
        weights = (along <= along.max() - DOUBTFUL).astype(np.float64)
        basis = np.stack((np.ones_like(along), along, along**2 / 2), axis=1)
        for _ in range(REWEIGHTINGS):
            root = np.sqrt(weights)
            solution, *_ = np.linalg.lstsq(basis * root[:, None], across * root, rcond=None)
            residuals = across - basis @ solution
            weights = 1.0 / (1.0 + (residuals / USUAL_ERROR) ** 2)
        offset, slope, curvature = (float(value) for value in solution)
        return RememberedLine(
            straight.x - offset * sin,
            straight.y + offset * cos,
            straight.direction + math.atan(slope),
            min(max(curvature, -MOST_CURVATURE), MOST_CURVATURE),
        )

    def _straight_line(self) -> RememberedLine:
        last = self._observations[-1]
        directions = np.array([each.direction for each in self._observations])
        turned = np.remainder(directions - last.direction + np.pi, 2 * np.pi) - np.pi
        direction = last.direction + float(np.median(turned))
        cos, sin = math.cos(direction), math.sin(direction)
        places = np.array([(each.x - last.x, each.y - last.y) for each in self._observations])
        aside = float(np.median(places[:, 1] * cos - places[:, 0] * sin))
        return RememberedLine(last.x - aside * sin, last.y + aside * cos, direction)
