"""The altitude of the vehicle: checked, and taken to base_link."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cable_tracker.metric.frames import Attitude
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.sequences.bags.instruments import MOST_ALTITUDE

LEAST_ALTITUDE = 0.05
"""No smaller altitude is one of a vehicle that sees the bottom [m]."""


@dataclass(frozen=True, slots=True)
class Altitude:
    """Vertical distance of base_link from the sea bed.

    Attributes
    ----------
    metres : float
        [m].
    sigma : float
        Standard deviation of the altitude [m].
    """

    metres: float
    sigma: float = 0.0

    def fault(self) -> Withheld | None:
        """Return why it is no altitude of a vehicle that sees the bottom; None if it is one."""
        if not LEAST_ALTITUDE <= self.metres <= MOST_ALTITUDE:
            return Withheld(
                Reason.BAD_ALTITUDE,
                f"{self.metres:g} m is not within {LEAST_ALTITUDE:g} to {MOST_ALTITUDE:g} m",
            )
        if not 0.0 <= self.sigma < math.inf:
            return Withheld(Reason.BAD_ALTITUDE, f"its sigma is {self.sigma:g} m; give 0 or more")
        return None


@dataclass(frozen=True, slots=True)
class Altimeter:
    """How an altitude is measured.

    Attributes
    ----------
    position : (float, float, float)
        Position of the altimeter in base_link [m].
    is_vertical : bool
        Whether it gives the vertical distance, as a DVL that knows its attitude does. Otherwise it
        measures along the vehicle's own -z, as an echo sounder does.
    relative_sigma : float
        Standard deviation as a share of the altitude.
    """

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    is_vertical: bool = False
    relative_sigma: float = 0.01

    def read(
        self,
        measured: float,
        attitude: Attitude,
        limits: tuple[float, float] = (LEAST_ALTITUDE, MOST_ALTITUDE),
    ) -> Altitude | Withheld:
        """Return the altitude of base_link, or why there is none.

        Parameters
        ----------
        measured : float
            Measured range [m].
        attitude : Attitude
            Attitude of the vehicle.
        limits : (float, float)
            Smallest and largest distance that the altimeter can measure [m].
        """
        low, high = max(limits[0], LEAST_ALTITUDE), min(limits[1], MOST_ALTITUDE)
        if not math.isfinite(measured) or not low <= measured <= high:
            return Withheld(
                Reason.BAD_ALTITUDE,
                f"{measured:g} m is not within {low:g} to {high:g} m; look at the altimeter",
            )
        upright = math.cos(attitude.roll) * math.cos(attitude.pitch)
        if not upright > 0.0:
            return Withheld(Reason.BAD_ATTITUDE, "the vehicle hangs upside down; look at the imu")
        vertical = measured if self.is_vertical else measured * upright
        # Ahead of base_link it comes nearer to the bottom as the vehicle pitches.
        metres = vertical - float(attitude.rotation[2] @ self.position)
        if metres < LEAST_ALTITUDE:
            return Withheld(
                Reason.BAD_ALTITUDE,
                f"base_link would be {metres:g} m above the bottom; see altimeter_x, altimeter_y"
                " and altimeter_z",
            )
        return Altitude(metres, self.relative_sigma * metres)
