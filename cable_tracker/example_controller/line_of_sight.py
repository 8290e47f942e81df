"""Line-of-sight guidance: steer for a point of the cable some way ahead.

With an integral part against current, which slows down far from the cable so that it does not wind
up, after E. Børhaug, A. Pavlov and K. Y. Pettersen, "Integral LOS control for path following of
underactuated marine surface vessels in the presence of constant ocean currents" (2008).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cable_tracker.example_controller.command import Command
from cable_tracker.tracking.parameter_table import ParameterSet, number

MOST_INTEGRAL = 1.5
"""Largest shift of the cable by the integral part [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GuidanceSettings(ParameterSet):
    """Settings of the steering."""

    speed: float = number(0.5, "m/s", 0.0, 5.0, "Speed forward, through the water.")
    look_ahead: float = number(
        1.2,
        "m",
        0.1,
        50.0,
        "Distance ahead of the point of the cable that the vehicle steers for; larger: smoother"
        " and slower to return.",
    )
    integral_gain: float = number(
        0.1, "1/s", 0.0, 1.0, "Integral gain of the lateral offset, against a current."
    )
    turn_gain: float = number(1.2, "1/s", 0.0, 10.0, "Turn rate per radian of course error.")
    most_turn: float = number(0.5, "rad/s", 0.01, 3.0, "Largest turn rate.")


@dataclass(frozen=True, slots=True)
class CableLine:
    """The cable relative to the vehicle, as in `cross_track`.

    Attributes
    ----------
    offset : float
        y of the cable at x = 0; positive: the cable is to the left [m].
    heading : float
        Direction of the cable from the vehicle's; positive: the cable leads to the left [rad].
    """

    offset: float
    heading: float


class LineOfSight:
    """Guidance law: turns the line of the cable into commands.

    Parameters
    ----------
    settings : GuidanceSettings
        Settings of the guidance law.
    """

    def __init__(self, settings: GuidanceSettings) -> None:
        self._settings = settings
        self._integral = 0.0

    def steer(self, cable: CableLine, seconds: float, speed: float | None = None) -> Command:
        """Return the next command.

        Parameters
        ----------
        cable : CableLine
            Current line of the cable.
        seconds : float
            Time since the command before [s].
        speed : float or None
            Instead of that of the settings [m/s].
        """
        settings = self._settings
        error = cable.offset * math.cos(cable.heading)
        ahead = settings.look_ahead
        share = ahead**2 / (ahead**2 + (error + self._integral) ** 2)
        grown = self._integral + settings.integral_gain * error * share * seconds
        self._integral = min(max(grown, -MOST_INTEGRAL), MOST_INTEGRAL)
        course = cable.heading + math.atan2(error + self._integral, ahead)
        turn = min(max(settings.turn_gain * course, -settings.most_turn), settings.most_turn)
        wanted = settings.speed if speed is None else speed
        # Far off the course, turning comes first.
        return Command(wanted * max(math.cos(course), 0.0), turn)
