"""Keep a distance behind a target, as an example: its position in, surge, heave and turn out.

The surge has an integral part, which comes to be the target's own speed and the current's. Where
there is no answer for a frame or two the last command goes on; while the target is lost the
integral part carries the vehicle on. After a while the vehicle also looks to both sides of its
course in turn, farther every time, beginning on the side of the last bearing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from cable_tracker.example_controller.command import HOLD_TIME, STOP, Command
from cable_tracker.example_controller.step_clock import StepClock
from cable_tracker.tracking.parameter_table import ParameterSet, number


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowSettings(ParameterSet):
    """Settings of the follower."""

    distance: float = number(2.5, "m", 0.3, 100.0, "Distance to the target that the vehicle keeps.")
    gain: float = number(0.5, "1/s", 0.0, 10.0, "Surge speed per metre of distance error.")
    integral_gain: float = number(0.06, "1/s²", 0.0, 10.0, "Integral gain of the distance error.")
    most_surge: float = number(
        0.8, "m/s", 0.0, 5.0, "Largest surge speed forward; backward half of it."
    )
    turn_gain: float = number(1.0, "1/s", 0.0, 10.0, "Turn rate per radian of bearing.")
    most_turn: float = number(0.5, "rad/s", 0.01, 3.0, "Largest turn rate.")
    climb_gain: float = number(
        0.5, "1/s", 0.0, 10.0, "Heave speed per metre of height difference to the target."
    )
    most_heave: float = number(0.2, "m/s", 0.0, 2.0, "Largest heave speed, up or down.")
    memory_time: float = number(
        8.0,
        "s",
        0.0,
        600.0,
        "Time after the loss of the target for which the vehicle goes on as before; then it"
        " searches.",
    )
    give_up: float = number(
        60.0, "s", 0.0, 1e5, "Time without the target after which the vehicle stands still."
    )
    search_turn: float = number(
        0.3,
        "rad/s",
        0.0,
        3.0,
        "Turn rate of the search, at most `most_turn`.",
    )
    search_angle: float = number(
        0.4,
        "rad",
        0.05,
        3.0,
        "Angle of the first turn of the search to either side; the next ones are larger.",
    )


@dataclass(frozen=True, slots=True)
class TargetPlace:
    """Position of a target relative to the vehicle.

    Attributes
    ----------
    ahead, left, up : float
        [m].
    """

    ahead: float
    left: float
    up: float

    @property
    def range(self) -> float:
        """Distance [m]."""
        return math.sqrt(self.ahead**2 + self.left**2 + self.up**2)

    @property
    def bearing(self) -> float:
        """Bearing, to the left positive [rad]."""
        return math.atan2(self.left, self.ahead)


class FollowMode(str, Enum):
    """Mode of the follower."""

    WAITING = "WAITING"
    FOLLOWING = "FOLLOWING"
    REMEMBERING = "REMEMBERING"
    SEARCHING = "SEARCHING"
    GIVEN_UP = "GIVEN UP"


class TargetController:
    """Turns positions of a target into commands.

    Parameters
    ----------
    settings : FollowSettings
        Settings of distance, gains and search.
    """

    def __init__(self, settings: FollowSettings) -> None:
        self._settings = settings
        self._mode = FollowMode.WAITING
        self._integral = 0.0
        self._last: TargetPlace | None = None
        self._last_time = 0.0
        self._command = STOP
        self._clock = StepClock()

    @property
    def mode(self) -> FollowMode:
        """Mode of the follower."""
        return self._mode

    def step(self, time: float, place: TargetPlace | None) -> Command:
        """Return the command for a time.

        Parameters
        ----------
        time : float
            Time of the frame [s]; a clock that is set back stands still for one step.
        place : TargetPlace or None
            Position of the target; None while it is lost.
        """
        dt = self._clock.advance(time)
        if place is not None:
            self._last, self._last_time = place, self._clock.now
            self._mode = FollowMode.FOLLOWING
            self._command = self._follow(place, dt)
            return self._command
        return self._command_without(self._clock.now - self._last_time)

    def _command_without(self, lost: float) -> Command:
        """Return the command without a target, `lost` seconds after the last position."""
        if self._last is None:
            self._mode = FollowMode.WAITING
            return STOP
        if lost > self._settings.give_up:
            self._mode = FollowMode.GIVEN_UP
            return STOP
        if lost <= HOLD_TIME:
            return self._command
        if lost <= self._settings.memory_time:
            self._mode = FollowMode.REMEMBERING
            # The turn for the last bearing fades away: by then the vehicle has made it.
            turn = self._turn(self._last.bearing) * math.exp(-lost)
            return Command(self._limited_surge(self._integral), turn)
        self._mode = FollowMode.SEARCHING
        begun = max(self._settings.memory_time, HOLD_TIME)
        return self._search(lost - begun, self._last.bearing)

    def _follow(self, place: TargetPlace, dt: float) -> Command:
        settings = self._settings
        too_far = place.range - settings.distance
        wanted = settings.gain * too_far + self._integral
        # The integral stands still while the surge is at its limit.
        if self._limited_surge(wanted) == wanted:
            self._integral += settings.integral_gain * too_far * dt
        surge = self._limited_surge(wanted) * max(math.cos(place.bearing), 0.0)
        heave = min(max(settings.climb_gain * place.up, -settings.most_heave), settings.most_heave)
        return Command(surge, self._turn(place.bearing), heave)

    def _search(self, seconds: float, bearing: float) -> Command:
        """Return the turn to one side or the other, `seconds` after the search has begun."""
        settings = self._settings
        surge, side = self._limited_surge(self._integral), 1.0 if bearing >= 0.0 else -1.0
        # Each leg goes from one side to the other, and farther than the one before: by 1, 3, 5 ...
        # times the first angle, so that the first n of them take n squared times as long.
        turn = min(settings.search_turn, settings.most_turn)
        legs = math.isqrt(int(seconds * turn / settings.search_angle))
        return Command(surge, -side * turn if legs % 2 else side * turn)

    def _limited_surge(self, surge: float) -> float:
        most = self._settings.most_surge
        return min(max(surge, -0.5 * most), most)

    def _turn(self, bearing: float) -> float:
        most = self._settings.most_turn
        return min(max(self._settings.turn_gain * bearing, -most), most)
