"""The state of a cable in the image, and how its columns are named and shown."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray

DISTANCE, ANGLE, WIDTH, SKEW, DISTANCE_RATE, ANGLE_RATE, WIDTH_RATE, SKEW_RATE = range(8)
"""Columns of an array of states, shape (N, 8), see `CableState`."""

STATE_SIZE = 8

LENGTHS = [DISTANCE, WIDTH, DISTANCE_RATE, WIDTH_RATE]
"""Columns of a state that are in pixels."""

POSE_SIZE = 4
"""Pose components: the first columns, d, alpha, w, beta; as many rates follow."""

DEGREE = math.degrees(1.0)
"""Factor from rad to degrees."""


class Component(NamedTuple):
    """A component of the state as it is shown to people, in degrees instead of rad.

    Attributes
    ----------
    symbol, greek : str
        Symbol of the thesis (sections 4.3 and 6.1), spelt out and as it is written there.
    unit : str
        Unit in which it is shown.
    factor : float
        Factor from px or rad, or their rates, to that unit.
    """

    symbol: str
    greek: str
    unit: str
    factor: float

    @property
    def heading(self) -> str:
        """Symbol and unit, for a table's column or an axis."""
        return f"{self.symbol} [{self.unit}]"


COMPONENTS = (
    Component("d", "d", "px", 1.0),
    Component("alpha", "α", "deg", DEGREE),
    Component("w", "w", "px", 1.0),
    Component("beta", "β", "deg", DEGREE),
    Component("v_d", "v_d", "px/s", 1.0),
    Component("v_alpha", "v_α", "deg/s", DEGREE),
    Component("v_w", "v_w", "px/s", 1.0),
    Component("v_beta", "v_β", "deg/s", DEGREE),
)
"""In the order of the columns."""

POSE_COMPONENTS = COMPONENTS[:POSE_SIZE]

POSE_WORDS = ("d {:.1f} px", "alpha {:.3f} rad", "w {:.1f} px", "beta {:.3f} rad")
"""What logs say of a pose, by column."""

STATE_SYMBOLS = tuple(each.symbol for each in COMPONENTS)
POSE_SYMBOLS = STATE_SYMBOLS[:POSE_SIZE]


def pose_units(scale: float) -> FloatArray:
    """Return factors that bring d, alpha, w, beta from the reference width to a scale, shape (4,).

    `scale` is that of lengths, see `pixel_scale`; angles stay as they are.
    """
    return np.array([scale, 1.0, scale, 1.0])


@dataclass(frozen=True, slots=True)
class CableState:
    """Where the cable runs in the image, and how fast that changes.

    The image frame has its origin at the image centre, x to the right, y up, in pixels.

    Attributes
    ----------
    distance : float
        d, signed distance from the image centre to the centreline [px]:
        ``x cos(angle) + y sin(angle) = distance``.
    angle : float
        alpha, angle of the centreline's normal from +x [rad], counter-clockwise positive,
        in (-pi/2, pi/2].
    width : float
        w, distance between the borders along the normal through the foot point [px].
    skew : float
        beta, angle between each border and the centreline [rad]; positive when the borders
        converge upwards.
    distance_rate : float
        v_d [px/s].
    angle_rate : float
        v_alpha [rad/s].
    width_rate : float
        v_w [px/s].
    skew_rate : float
        v_beta [rad/s].
    """

    distance: float
    angle: float
    width: float
    skew: float = 0.0
    distance_rate: float = 0.0
    angle_rate: float = 0.0
    width_rate: float = 0.0
    skew_rate: float = 0.0

    def to_array(self) -> FloatArray:
        """Return the state as an array of shape (8,), in the order of the columns."""
        # Named one by one, for `astuple` copies each of them deeply, which takes far longer.
        return np.array(
            [
                self.distance, self.angle, self.width, self.skew,
                self.distance_rate, self.angle_rate, self.width_rate, self.skew_rate,
            ],
            np.float64,
        )  # fmt: skip

    @classmethod
    def from_array(cls, values: FloatArray) -> CableState:
        """Make a state from an array of shape (8,), or (4,) for a state at rest."""
        return cls(*values.tolist())

    def scaled(self, factor: float) -> CableState:
        """Return the cable as it looks in an image enlarged by a factor."""
        return replace(
            self,
            distance=self.distance * factor,
            width=self.width * factor,
            distance_rate=self.distance_rate * factor,
            width_rate=self.width_rate * factor,
        )

    def at_rest(self) -> CableState:
        """Return where the cable is, without its rates."""
        return CableState(self.distance, self.angle, self.width, self.skew)

    def is_finite(self) -> bool:
        """Tell whether every component is a finite number."""
        return bool(np.isfinite(self.to_array()).all())
