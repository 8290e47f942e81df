"""Lines across the cable, each merged from the pictures that show it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cable_tracker.survey.forward_pass import ForwardDive
from cable_tracker.survey.frame_table import TRACKING
from cable_tracker.survey.routes.route import Course

CROSSING_REACH, CROSSING_ANGLE = 0.6, math.radians(20.0)
"""Largest distance and angle between observations of one crossing [m, rad]."""

FEWEST_PICTURES = 4
"""Smallest number of pictures of a crossing cable; a line in fewer is a rope or a shadow."""


class LocatedObservation(NamedTuple):
    """A line across the cable in one picture, located along the route.

    Attributes
    ----------
    along : float
        Arc length along the route [m].
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
        Arc length along the route [m].
    across : float
        Angle against the cable, positive [rad].
    pictures : int
        Number of pictures that show it.
    """

    along: float
    across: float
    pictures: int


def find_crossings(dive: ForwardDive, course: Course, start: float, piece: int) -> list[Crossing]:
    """Return the crossings of a connected piece, along a route that starts at an arc length [m]."""
    keyframes, cable, crossings = course.keyframes, course.cable, dive.table.crossings
    observations = []
    for part in dive.disk.blocks(len(crossings)):
        for observation in crossings[part]:
            row = dive.table.rows[observation.row]
            keyframe = int(keyframes.of(np.array([observation.row]))[0])
            if keyframe < 0 or row["status"] != TRACKING or cable.piece[keyframe] != piece:
                continue
            heading = float(cable.states[keyframe, 1])
            beyond = (observation.ahead - float(row["look"])) / math.cos(heading)
            along = float(cable.along[keyframe]) + beyond - start
            direction = float(keyframes.look_lines[keyframe, 2]) + observation.angle
            across = math.remainder(observation.angle - heading, math.pi)
            observations.append(LocatedObservation(along, direction, across, observation.row))
    return [
        each
        for each in merge_observations(sorted(observations))
        if each.pictures >= FEWEST_PICTURES
    ]


def merge_observations(observations: Sequence[LocatedObservation]) -> list[Crossing]:
    """Merge observations of the same place and direction on the sea bed into one crossing each."""
    groups: list[list[LocatedObservation]] = []
    for observation in observations:
        for group in reversed(groups):
            near = (
                abs(observation.along - np.median([each.along for each in group])) < CROSSING_REACH
            )
            turn = abs(math.remainder(observation.direction - group[-1].direction, math.pi))
            if near and turn < CROSSING_ANGLE:
                group.append(observation)
                break
        else:
            groups.append([observation])
    return [
        Crossing(
            float(np.median([each.along for each in group])),
            # Right angles are written as 90 deg or as -90.
            float(np.median([abs(each.across) for each in group])),
            len({each.row for each in group}),
        )
        for group in groups
    ]
