"""Finds lines across the cable: other cables, pipes and ropes."""

from __future__ import annotations

import math

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.detection.baselines.hough import HoughDetector
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.stamps import NANOSECONDS
from cable_tracker.survey.frames.frame_table import CrossingObservation, FrameTable
from cable_tracker.tracking.succession import SMALLEST_SIDE

CROSSING_STRIDE = 0.5
"""Interval between two pictures that are searched for lines across the cable [s]."""

CROSSING_WIDTH = 160
"""Width of the picture that is searched [px]: a line's place need not be exact to a pixel."""

LEAST_CROSSING = math.radians(25.0)
"""Smallest angle of a crossing line to the cable; one that runs less across is not told from the
cable's own borders, ropes and furrows beside it [rad]."""

LEAST_SCORE = 0.3
"""Lines across that are seen less clearly do not count."""


class CrossingSearch:
    """Searches pictures now and then for lines across the cable, and notes them in the table.

    Parameters
    ----------
    table : FrameTable
        Table of the dive; its last row is that of the picture.
    """

    def __init__(self, table: FrameTable) -> None:
        self._table = table
        self._finder = HoughDetector()
        self._searched = -(2**62)

    def search(self, view: GroundView, grey: Image, estimate: CableEstimate) -> None:
        """Look for lines across a cable, unless the last picture that was searched is too near."""
        # Where the clock has been set back the next picture is searched.
        if 0 <= estimate.stamp - self._searched < round(CROSSING_STRIDE * NANOSECONDS):
            return
        self._searched = estimate.stamp
        state, (width, height) = estimate.state, estimate.image_size
        own = np.array([math.cos(state.angle), math.sin(state.angle)])
        # A long, low picture keeps as many rows as a detector needs.
        scale = max(min(width / CROSSING_WIDTH, height / SMALLEST_SIDE), 1.0)
        for found in self._finder.detect(_reduced(grey, scale)):
            other = found.state.scaled(scale)
            across = abs(math.remainder(other.angle - state.angle, math.pi))
            if found.score < LEAST_SCORE or across < LEAST_CROSSING:
                continue
            normal = np.array([math.cos(other.angle), math.sin(other.angle)])
            place = np.linalg.solve(np.array([own, normal]), [state.distance, other.distance])
            if abs(place[0]) > width / 2 or abs(place[1]) > height / 2:
                continue
            along = np.array([-normal[1], normal[0]])
            near, far = view.on_ground(np.array([place - 5.0 * along, place + 5.0 * along]))
            # Above the horizon there is no ground that a line could lie on.
            if not np.isfinite((near, far)).all():
                continue
            middle = (near + far) / 2
            angle = math.remainder(math.atan2(far[1] - near[1], far[0] - near[0]), math.pi)
            observation = CrossingObservation(len(self._table) - 1, float(middle[0]), angle)
            self._table.crossings.append(observation)


def _reduced(grey: Image, scale: float) -> Image:
    """Return a picture whose sides are divided by a factor."""
    if scale <= 1.0:
        return grey
    size = (round(grey.shape[1] / scale), round(grey.shape[0] / scale))
    return cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
