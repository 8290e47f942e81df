"""Follow the cable; where it is lost, stop, and search along the line that it was last seen on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from cable_tracker.example_controller.cable_memory import (
    CableMemory,
    Pose,
    RememberedLine,
    line_at,
)
from cable_tracker.example_controller.command import PATIENCE, STOP, Command
from cable_tracker.example_controller.line_of_sight import Cable, GuidanceSettings, LineOfSight
from cable_tracker.example_controller.step_clock import StepClock
from cable_tracker.tracking.parameter_table import number

NEAR, NEAR_TURNED = 0.2, math.radians(20.0)
"""Largest distance and angle of the cable from where it is expected [m, rad]."""

GATE_GROWTH, GATE_TURN, MOST_TURNED = 0.15, math.radians(5.0), math.radians(45.0)
"""Growth of these limits for each metre since the last sighting [m/m, rad/m], and the largest limit
of the angle [rad]."""

PROVEN = 2.0
"""Way over which a cable must be followed to be sure; one lost earlier may have been something else
[m]."""

FORMER_COUNTS = 10.0
"""The line before the present one may be the cable's for this way from where it was left [m]."""

LONGEST_SEARCH = 3.0
"""A search ends after the time in which still water would let it go so many times its length: a
head current of half its speed leaves it whole, and one that holds the vehicle does not let it
search for ever."""

PAUSE = 1.0
"""Time of standstill after the last command has gone on without an answer [s]."""

STRAIGHT = 6.0
"""Way over which the search follows the remembered line itself [m]."""

SWEEP_GROWTH, MOST_SWEEP = 0.25, 1.5
"""Growth of the sweeps to both sides after that, for each metre [m/m], and the farthest sweep to a
side [m]."""

SWEEP_LENGTH = 6.0
"""Way along the line for a sweep to both sides [m]."""

CONFIRMATIONS = 5
"""Sightings in a row that end the search; refused frames between them do not count."""

FASTEST, MOST_JITTER, MOST_YAW_JITTER = 2.0, 0.3, math.radians(30.0)
"""A pose farther from the last one than so many times the fastest command, and by these more [m,
rad], is no motion of the vehicle: odometry has begun anew or was corrected."""


class Mode(Enum):
    """Mode of the controller."""

    WAITING = "WAITING"
    """Wait for the first sight of the cable; the vehicle stands still."""
    FOLLOWING = "FOLLOWING"
    STOPPED = "STOPPED"
    """Stop after the loss of the cable: stand still for a moment, it may come back."""
    SEARCHING = "SEARCHING"
    GIVEN_UP = "GIVEN UP"
    """End of a search without success; the vehicle stands still."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerSettings(GuidanceSettings):
    """Settings of the steering, and of the search for a lost cable."""

    search_speed: float = number(0.35, "m/s", 0.0, 5.0, "Speed while the cable is looked for.")
    search_length: float = number(
        25.0, "m", 0.0, 1e4, "Search so far along the line where the cable was, then give up."
    )


def sweep(progress: float) -> float:
    """Return how far to the left of the line a search is after some way along it [m]."""
    beyond = max(progress - STRAIGHT, 0.0)
    reach = min(SWEEP_GROWTH * beyond, MOST_SWEEP)
    return reach * math.sin(2 * math.pi * beyond / SWEEP_LENGTH)


class Controller:
    """Follows the cable.

    Parameters
    ----------
    settings : ControllerSettings
        How to follow and how to search.
    """

    def __init__(self, settings: ControllerSettings = ControllerSettings()) -> None:
        self._settings = settings
        self._guidance = LineOfSight(settings)
        self._mode = Mode.WAITING
        self._clock = StepClock()
        self._last_seen = -math.inf
        self._in_a_row = 0
        self._searched = 0.0
        self._command = STOP
        self._last_pose: tuple[float, Pose] | None = None
        self._forget()

    def _forget(self) -> None:
        """Forget where the cable was."""
        self._memory = CableMemory()
        self._sighting: RememberedLine | None = None
        self._line: RememberedLine | None = None
        self._former_line: RememberedLine | None = None

    @property
    def mode(self) -> Mode:
        """Mode of the controller."""
        return self._mode

    def step(
        self, time: float, cable: Cable | None, pose: Pose | None, *, is_processed: bool = True
    ) -> Command:
        """Return the command for a time.

        Parameters
        ----------
        time : float
            Time of the measurements [s]; a clock that is set back stands still for one step, and
            where the cable was is forgotten. A frame that was overtaken sets none back.
        cable : Cable or None
            Line of the cable; None if the tracker does not say.
        pose : Pose or None
            From odometry; None without. Then a lost cable is not searched for. Where it jumps,
            where the cable was is forgotten.
        is_processed : bool
            Whether the tracker has processed the frame. One that it has refused says nothing of the
            cable: it neither interrupts sightings in a row nor is one of them; time goes on.
        """
        seconds = self._clock.advance(time)
        if self._clock.was_set_back or self._has_jumped(pose):
            self._forget()
        if pose is not None:
            self._last_pose = self._clock.now, pose
        if cable is not None and self._is_credible(cable, pose):
            self._in_a_row += 1
            is_back = self._in_a_row >= CONFIRMATIONS
            if is_back or self._mode is Mode.FOLLOWING:
                return self._follow(seconds, cable, pose)
        elif is_processed:
            self._in_a_row = 0
        self._command = self._without(seconds, pose)
        return self._command

    def _has_jumped(self, pose: Pose | None) -> bool:
        """Tell whether no motion of the vehicle leads from the last pose to this one."""
        if pose is None or self._last_pose is None:
            return False
        then, before = self._last_pose
        settings, seconds = self._settings, self._clock.now - then
        way = math.dist((before.x, before.y), (pose.x, pose.y))
        turned = abs(math.remainder(pose.yaw - before.yaw, 2 * math.pi))
        speed = max(settings.speed, settings.search_speed)
        return (
            way > FASTEST * speed * seconds + MOST_JITTER
            or turned > FASTEST * settings.most_turn * seconds + MOST_YAW_JITTER
        )

    def _follow(self, seconds: float, cable: Cable, pose: Pose | None) -> Command:
        if self._mode is not Mode.FOLLOWING:
            # What was found may be something else: it must not mix with what was seen before.
            self._memory = CableMemory()
        self._mode = Mode.FOLLOWING
        self._last_seen = self._clock.now
        if pose is not None:
            self._memory.add(cable, pose)
            self._sighting = line_at(cable, pose)
        self._command = self._guidance.steer(cable, seconds)
        return self._command

    def _is_credible(self, cable: Cable, pose: Pose | None) -> bool:
        """Tell whether this may be the cable that was seen before, and not something beside it.

        What is followed must go on where it was a moment ago; what is found, where the line leads.
        A search that was given up has shown that this line leads nowhere.
        """
        if self._mode is Mode.GIVEN_UP:
            return True
        line = self._sighting if self._mode is Mode.FOLLOWING else self._line
        if pose is None or line is None or _lies_along(cable, line, pose):
            return True
        former = self._former_line
        if self._mode is Mode.FOLLOWING or former is None or former.progress(pose) > FORMER_COUNTS:
            return False
        # What was followed since may have been something else, for all its length.
        return _lies_along(cable, former, pose)

    def _without(self, seconds: float, pose: Pose | None) -> Command:
        """Return the command while the cable is not seen."""
        settings = self._settings
        if self._mode in {Mode.WAITING, Mode.GIVEN_UP}:
            return STOP
        waited = self._clock.now - self._last_seen
        if waited <= PATIENCE:
            return self._command
        if self._mode is Mode.FOLLOWING:
            self._searched = 0.0
            self._remember()
        if waited <= PATIENCE + PAUSE or pose is None or self._line is None:
            self._mode = Mode.STOPPED
            return STOP
        progress = self._line.progress(pose)
        self._searched += settings.search_speed * seconds
        if (
            progress > settings.search_length
            or self._searched > LONGEST_SEARCH * settings.search_length
        ):
            self._mode = Mode.GIVEN_UP
            return STOP
        self._mode = Mode.SEARCHING
        wanted = self._line.seen_from(pose, sweep(progress))
        return self._guidance.steer(wanted, seconds, settings.search_speed)

    def _remember(self) -> None:
        """Choose the line to search along.

        What was lost again soon after it was found may have been a furrow or a shadow: then the
        search goes on along the line from before. A single sighting is better than no line at all.
        """
        if self._line is None or self._memory.way >= PROVEN:
            self._former_line = self._line
            self._line = self._memory.line() or self._line or self._sighting


def _lies_along(cable: Cable, line: RememberedLine, pose: Pose) -> bool:
    """Tell whether what is seen from a pose may be what a line leads to."""
    expected, way = line.seen_from(pose), max(line.progress(pose), 0.0)
    turned = abs(math.remainder(cable.heading - expected.heading, math.pi))
    is_near = abs(cable.offset - expected.offset) < NEAR + GATE_GROWTH * way
    return is_near and turned < min(NEAR_TURNED + GATE_TURN * way, MOST_TURNED)
