"""The last map of a known cable, moved along with it: what frames without one of their own go by.

The network takes several times as long as the rest of a frame in which the cable is clear. So it
looks only now and then, and what it said of the strip, of its borders and of what lies beside it
stays true for a moment, but for how the cable has moved since. Borders alone prefer a bright stripe
along a pipe, or its lit half, to the whole of it: some time after the last map the filter would go
over to the stripe.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.measure.map.cable_map import NO_MAP, CableMap, cable_map_of
from cable_tracker.cable.measure.map.map_borders import AS_THE_STRIP, MapBorders
from cable_tracker.cable.model.geometry import pose_in_chart
from cable_tracker.cable.model.state import ANGLE, DISTANCE, POSE_SIZE
from cable_tracker.compilation import compiled

LONGEST_KEPT = 1.0
"""Age from which on a map says nothing any more [s]."""

BORDERS_TIME = 0.5
"""Time over which the borders by maps are smoothed [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class KeptMap:
    """A map of a frame before.

    Attributes
    ----------
    cable_map : CableMap
        The map.
    pose : FloatArray
        d, alpha, w, beta of the cable in that frame, shape (4,) [px, rad].
    borders : MapBorders
        Where it and the maps before it show the borders of the cable, smoothed [px].
    seconds : float
        Time since that frame [s].
    """

    cable_map: CableMap
    pose: FloatArray
    borders: MapBorders
    seconds: float = 0.0

    def smoothed(self, borders: MapBorders) -> MapBorders:
        """Return where this map and a new one, which shows `borders`, show those of the cable."""
        kept = math.exp(-self.seconds / BORDERS_TIME)
        both = zip(self.borders, borders, strict=True)
        return MapBorders(*(kept * old + (1.0 - kept) * new for old, new in both))

    def moved_to(self, pose: FloatArray) -> CableMap:
        """Return the map as it lies when the centreline of the cable has come to that of a pose.

        It turns about the image centre and moves across the centreline; `pose` (4 or more,) is one
        in any chart. Cells that come from beyond the picture are as the outermost ones. One that is
        `LONGEST_KEPT` old is `NO_MAP`.
        """
        if self.seconds >= LONGEST_KEPT:
            return NO_MAP
        probabilities = cv2.warpAffine(
            self.cable_map.probabilities,
            _cells_before(self.cable_map, self.pose, pose),
            self.cable_map.probabilities.shape[::-1],
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        cells = np.asarray(probabilities, np.float32)
        return cable_map_of(cells, self.cable_map.left, self.cable_map.top, self.cable_map.cell)


NO_KEPT_MAP = KeptMap(NO_MAP, np.zeros(POSE_SIZE), AS_THE_STRIP, math.inf)
"""Before any map: too old to say anything."""


@compiled
def _cells_before(cable_map: CableMap, before: FloatArray, now: FloatArray) -> FloatArray:
    """Return the affine map, shape (2, 3), from (column, row) of a moved map to those before.

    Parameters
    ----------
    cable_map : CableMap
        The map before.
    before, now : FloatArray
        Poses of the cable, shape (4,) or more, in any chart [px, rad]: it has turned about the
        image centre, and then moved along the normal of its centreline.
    """
    left, top, cell, angle = cable_map.left, cable_map.top, cable_map.cell, now[ANGLE]
    in_chart = np.empty(POSE_SIZE)
    pose_in_chart(before, angle, in_chart)
    turned, moved = angle - in_chart[ANGLE], now[DISTANCE] - in_chart[DISTANCE]
    cosine, sine = math.cos(turned), math.sin(turned)
    # From the image frame, y up: p = R(-turned) (p' - moved n').
    first_x = left - moved * math.cos(angle)
    first_y = top - moved * math.sin(angle)
    # Rows run downwards: (x', y') = first + cell (column, -row).
    return np.array(
        [
            [cosine, -sine, (cosine * first_x + sine * first_y - left) / cell],
            [sine, cosine, (top + sine * first_x - cosine * first_y) / cell],
        ]
    )
