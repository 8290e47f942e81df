"""Lines across the cable, put together from the pictures that show them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cable_tracker.survey.frames.forward_pass import ForwardDive
from cable_tracker.survey.frames.frame_table import TRACKING
from cable_tracker.survey.routes.route import Course

CROSSING_REACH, CROSSING_ANGLE = 0.6, math.radians(20.0)
"""Sights of one crossing lie so near to each other [m, rad]."""

FEWEST_SIGHTS = 4
"""Smallest number of pictures of a crossing cable; a line in fewer is a rope or a shadow."""


class LocatedSight(NamedTuple):
    """A line across the cable, as one picture shows it.

    Attributes
    ----------
    along : float
        Way along the route [m].
    direction, across : float
        Direction on the sea bed, and angle against the cable [rad].
    row : int
        Row of the picture in the table.
    """

    along: float
    direction: float
    across: float
    row: int


class Crossing(NamedTuple):
    """A line across the cable.

    Attributes
    ----------
    along : float
        Way along the route [m].
    across : float
        Angle against the cable, positive [rad].
    pictures : int
        Number of pictures that show it.
    """

    along: float
    across: float
    pictures: int


def find_crossings(dive: ForwardDive, course: Course, start: float, piece: int) -> list[Crossing]:
    """Return the crossings of a connected piece, along a route that starts at a way [m]."""
    keyframes, cable, crossings = course.keyframes, course.cable, dive.table.crossings
    sights = []
    for part in dive.disk.blocks(len(crossings)):
        for sight in crossings[part]:
            row = dive.table.rows[sight.row]
            keyframe = int(keyframes.of(np.array([sight.row]))[0])
            if keyframe < 0 or row["status"] != TRACKING or cable.piece[keyframe] != piece:
                continue
            heading = float(cable.states[keyframe, 1])
            beyond = (sight.ahead - float(row["look"])) / math.cos(heading)
            along = float(cable.along[keyframe]) + beyond - start
            direction = float(keyframes.places[keyframe, 2]) + sight.angle
            across = math.remainder(sight.angle - heading, math.pi)
            sights.append(LocatedSight(along, direction, across, sight.row))
    return [each for each in put_together(sorted(sights)) if each.pictures >= FEWEST_SIGHTS]


def put_together(sights: Sequence[LocatedSight]) -> list[Crossing]:
    """Put sights of the same place and direction on the sea bed together."""
    groups: list[list[LocatedSight]] = []
    for sight in sights:
        for group in reversed(groups):
            near = abs(sight.along - np.median([each.along for each in group])) < CROSSING_REACH
            turn = abs(math.remainder(sight.direction - group[-1].direction, math.pi))
            if near and turn < CROSSING_ANGLE:
                group.append(sight)
                break
        else:
            groups.append([sight])
    return [
        Crossing(
            float(np.median([each.along for each in group])),
            # Right angles are written as 90 deg or as -90.
            float(np.median([abs(each.across) for each in group])),
            len({each.row for each in group}),
        )
        for group in groups
    ]
