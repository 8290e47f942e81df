"""Line-of-sight guidance: steer for a point of the cable some way ahead.

With an integral part against current, which slows down far from the cable so that it does not wind
up, after E. Børhaug, A. Pavlov and K. Y. Pettersen, "Integral LOS control for path following of
underactuated marine surface vessels in the presence of constant ocean currents" (2008).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cable_tracker.example_controller.command import Command


@dataclass(frozen=True, slots=True)
class GuidanceSettings:
    """Settings of the steering.

    Attributes
    ----------
    speed : float
        Speed forward, through the water [m/s].
    look_ahead : float
        Distance ahead of the point of the cable that the vehicle steers for [m].
    integral_gain : float
        Gain against a lasting offset [1/s].
    most_integral : float
        Largest shift of the cable by the integral part [m].
    turn_gain : float
        Rate of turn for each radian off the course to steer [1/s].
    most_turn : float
        Largest rate of turn [rad/s].
    """

    speed: float = 0.5
    look_ahead: float = 1.2
    integral_gain: float = 0.1
    most_integral: float = 1.5
    turn_gain: float = 1.2
    most_turn: float = 0.5


@dataclass(frozen=True, slots=True)
class Cable:
    """The cable beside the vehicle, as `cross_track` says it.

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
    """Turns where the cable is into what to do.

    Parameters
    ----------
    settings : GuidanceSettings
        Settings of the guidance law.
    """

    def __init__(self, settings: GuidanceSettings) -> None:
        self._settings = settings
        self._integral = 0.0

    def steer(self, cable: Cable, seconds: float, speed: float | None = None) -> Command:
        """Return the next command.

        Parameters
        ----------
        cable : Cable
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
        self._integral = min(max(grown, -settings.most_integral), settings.most_integral)
        course = cable.heading + math.atan2(error + self._integral, ahead)
        turn = min(max(settings.turn_gain * course, -settings.most_turn), settings.most_turn)
        wanted = settings.speed if speed is None else speed
        # Far off the course, turning comes first.
        return Command(wanted * max(math.cos(course), 0.0), turn)
