"""Last known line of the cable in the frame of the vehicle's odometry."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from cable_tracker.example_controller.line_of_sight import Cable

REMEMBERED = 5.0
"""Length of the way whose sightings count [m]."""

FEWEST = 5
"""Sightings needed for a line."""

BENT_FROM = 2.0
"""Shortest way of sightings over which a bend is told from noise [m]."""

BEND_LASTS = 5.0
"""Length over which a bend is extrapolated; beyond it the cable runs straight on [m]."""

MOST_CURVATURE = 0.08
"""[1/m]."""

DOUBTFUL = 0.3
"""The sightings of the last way are doubted first: the cable was about to disappear [m]."""

USUAL_ERROR = 0.03
"""Sightings farther off the curve than this count less and less [m]."""

REWEIGHTINGS = 4

LEAST_COSINE = 0.1
"""Lines that run more across the vehicle are as far beside it as at that cosine of the angle."""


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
    """A line that goes on where the cable was seen last.

    Attributes
    ----------
    x, y : float
        A point of it in odom [m].
    direction : float
        There [rad].
    curvature : float
        To the left positive, for a while before and behind that point [1/m].
    """

    x: float
    y: float
    direction: float
    curvature: float = 0.0

    def progress(self, pose: Pose) -> float:
        """Return how far along the line the vehicle is, from its point [m]."""
        cos, sin = math.cos(self.direction), math.sin(self.direction)
        return (pose.x - self.x) * cos + (pose.y - self.y) * sin

    def seen_from(self, pose: Pose, aside: float = 0.0) -> Cable:
        """Return the line, shifted to its left by `aside` [m], as `cross_track` would say it."""
        cos, sin = math.cos(self.direction), math.sin(self.direction)
        along = self.progress(pose)
        across = (pose.y - self.y) * cos - (pose.x - self.x) * sin
        bent = min(max(along, -REMEMBERED), BEND_LASTS)
        slope = self.curvature * bent
        bend = slope * (along - bent / 2)
        heading = math.remainder(self.direction + math.atan(slope) - pose.yaw, 2 * math.pi)
        left = aside + (bend - across) * math.cos(math.atan(slope))
        return Cable(_offset_at_vehicle(left, heading), heading)


def _offset_at_vehicle(left: float, heading: float) -> float:
    """Return y of a line at x = 0, from how far it is to the left, seen in its direction [m].

    Beyond a right angle what is to the left of the line is to the right of the vehicle.
    """
    cos = math.cos(heading)
    return left / math.copysign(max(abs(cos), LEAST_COSINE), cos)


def line_at(cable: Cable, pose: Pose) -> RememberedLine:
    """Return the straight line on which a cable is seen from a pose."""
    x = pose.x - cable.offset * math.sin(pose.yaw)
    y = pose.y + cable.offset * math.cos(pose.yaw)
    return RememberedLine(x, y, pose.yaw + cable.heading)


@dataclass(frozen=True, slots=True)
class _Sighting:
    x: float
    y: float
    direction: float
    vehicle: tuple[float, float]


LEAST_WAY = 0.01
"""Shortest way from one sighting that is remembered to the next but one [m]."""


class CableMemory:
    """The sightings of the last metres."""

    def __init__(self) -> None:
        self._sightings: deque[_Sighting] = deque()

    def add(self, cable: Cable, pose: Pose) -> None:
        """Remember where the cable is now."""
        seen = line_at(cable, pose)
        place = (pose.x, pose.y)
        if len(self._sightings) > 1 and math.dist(self._sightings[-2].vehicle, place) < LEAST_WAY:
            # A vehicle that hovers keeps the newest sighting alone.
            self._sightings.pop()
        self._sightings.append(_Sighting(seen.x, seen.y, seen.direction, place))
        while math.dist(self._sightings[0].vehicle, place) > REMEMBERED:
            self._sightings.popleft()

    @property
    def way(self) -> float:
        """Length of the way from the first sighting that counts to the last [m]."""
        if not self._sightings:
            return 0.0
        return math.dist(self._sightings[0].vehicle, self._sightings[-1].vehicle)

    def line(self) -> RememberedLine | None:
        """Return the line through the sightings; None if they are too few.

        While the cable disappears under sand, the last sightings may be off: they must not turn
        the line away.
        """
        if len(self._sightings) < FEWEST:
            return None
        straight = self._straight_line()
        cos, sin = math.cos(straight.direction), math.sin(straight.direction)
        x = np.array([each.x - straight.x for each in self._sightings])
        y = np.array([each.y - straight.y for each in self._sightings])
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
        last = self._sightings[-1]
        directions = np.array([each.direction for each in self._sightings])
        turned = np.remainder(directions - last.direction + np.pi, 2 * np.pi) - np.pi
        direction = last.direction + float(np.median(turned))
        cos, sin = math.cos(direction), math.sin(direction)
        places = np.array([(each.x - last.x, each.y - last.y) for each in self._sightings])
        aside = float(np.median(places[:, 1] * cos - places[:, 0] * sin))
        return RememberedLine(last.x - aside * sin, last.y + aside * cos, direction)
