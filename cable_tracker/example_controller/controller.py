"""Follow the cable; where it is lost, stop, and search along the line fitted to its last metres."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from cable_tracker.example_controller.cable_memory import (
    CableMemory,
    Pose,
    RememberedLine,
    line_of,
)
from cable_tracker.example_controller.command import HOLD_TIME, STOP, Command
from cable_tracker.example_controller.line_of_sight import CableLine, GuidanceSettings, LineOfSight
from cable_tracker.example_controller.step_clock import StepClock
from cable_tracker.tracking.parameter_table import number

NEAR, NEAR_TURNED = 0.2, math.radians(20.0)
"""Largest distance and angle of the cable from where it is expected [m, rad]."""

GATE_GROWTH, GATE_TURN, MOST_TURNED = 0.15, math.radians(5.0), math.radians(45.0)
"""Growth of these limits for each metre since the last observation [m/m, rad/m], and the largest
limit of the angle [rad]."""

PROVEN = 2.0
"""Distance over which a cable must be followed to be sure of it [m]."""

FORMER_COUNTS = 10.0
"""Distance past its end up to which the line before the present one may be the cable's [m]."""

LONGEST_SEARCH = 3.0
"""Longest search: its length through the water, as a multiple of `search_length`. A head current of
half the speed does not shorten it, and one that holds the vehicle ends it."""

PAUSE = 1.0
"""Time of standstill after the last command has gone on without an answer [s]."""

STRAIGHT = 6.0
"""Distance over which the search follows the remembered line itself [m]."""

SWEEP_GROWTH, MOST_SWEEP = 0.25, 1.5
"""Growth of the sweeps to both sides after that, for each metre [m/m], and the farthest sweep to a
side [m]."""

SWEEP_LENGTH = 6.0
"""Distance along the line for a sweep to both sides [m]."""

CONFIRMATIONS = 5
"""Observations in a row that end the search; refused frames between them do not count."""

FASTEST, MOST_JITTER, MOST_YAW_JITTER = 2.0, 0.3, math.radians(30.0)
"""Limits of the motion between two poses: a multiple of the fastest command, and in addition [m,
rad]. Beyond them odometry has begun anew or was corrected."""


class Mode(Enum):
    """Mode of the controller."""

    WAITING = "WAITING"
    """Wait until the cable is first observed; the vehicle stands still."""
    FOLLOWING = "FOLLOWING"
    STOPPED = "STOPPED"
    """Stop after the loss of the cable: stand still for a moment, it may come back."""
    SEARCHING = "SEARCHING"
    GIVEN_UP = "GIVEN UP"
    """End of a search without success; the vehicle stands still."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerSettings(GuidanceSettings):
    """Settings of the steering, and of the search for a lost cable."""

    search_speed: float = number(
        0.35, "m/s", 0.0, 5.0, "Speed forward while the cable is searched for."
    )
    search_length: float = number(
        25.0,
        "m",
        0.0,
        1e4,
        "Length of the search along the line where the cable was, after which the controller"
        " gives up.",
    )


def sweep(progress: float) -> float:
    """Return the offset to the left of the line after some progress along it, in a search [m]."""
    beyond = max(progress - STRAIGHT, 0.0)
    reach = min(SWEEP_GROWTH * beyond, MOST_SWEEP)
    return reach * math.sin(2 * math.pi * beyond / SWEEP_LENGTH)


class Controller:
    """Follows the cable.

    Parameters
    ----------
    settings : ControllerSettings
        Settings of guidance and search.
    """

    def __init__(self, settings: ControllerSettings = ControllerSettings()) -> None:
        self._settings = settings
        self._guidance = LineOfSight(settings)
        self._mode = Mode.WAITING
        self._clock = StepClock()
        self._last_observed = -math.inf
        self._in_a_row = 0
        self._searched = 0.0
        self._command = STOP
        self._last_pose: tuple[float, Pose] | None = None
        self._forget()

    def _forget(self) -> None:
        """Drop all remembered lines of the cable."""
        self._memory = CableMemory()
        self._last_line: RememberedLine | None = None
        self._line: RememberedLine | None = None
        self._former_line: RememberedLine | None = None

    @property
    def mode(self) -> Mode:
        """Mode of the controller."""
        return self._mode

    def step(
        self, time: float, cable: CableLine | None, pose: Pose | None, *, is_processed: bool = True
    ) -> Command:
        """Return the command for a time.

        Parameters
        ----------
        time : float
            Time of the measurements [s]; a clock that is set back stands still for one step, and
            the lines of the cable are dropped. A frame that was overtaken sets none back.
        cable : CableLine or None
            Line of the cable; None if none is claimed.
        pose : Pose or None
            From odometry; None without. Then a lost cable is not searched for. Where it jumps,
            the lines of the cable are dropped.
        is_processed : bool
            Whether the tracker has processed the frame. One that it has refused is no evidence: it
            neither interrupts observations in a row nor is one of them; time goes on.
        """
        seconds = self._clock.advance(time)
        if self._clock.was_set_back or self._odometry_jumped(pose):
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
        self._command = self._command_without(seconds, pose)
        return self._command

    def _odometry_jumped(self, pose: Pose | None) -> bool:
        """Return whether no motion of the vehicle leads from the last pose to this one."""
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

    def _follow(self, seconds: float, cable: CableLine, pose: Pose | None) -> Command:
        if self._mode is not Mode.FOLLOWING:
            # What was found may be something else: its observations must not mix with earlier ones.
            self._memory = CableMemory()
        self._mode = Mode.FOLLOWING
        self._last_observed = self._clock.now
        if pose is not None:
            self._memory.add(cable, pose)
            self._last_line = line_of(cable, pose)
        self._command = self._guidance.steer(cable, seconds)
        return self._command

    def _is_credible(self, cable: CableLine, pose: Pose | None) -> bool:
        """Return whether this may be the cable observed before, and not something beside it.

        While following it must continue the last line; after a loss, the remembered one. After a
        search was given up, any cable is credible.
        """
        if self._mode is Mode.GIVEN_UP:
            return True
        line = self._last_line if self._mode is Mode.FOLLOWING else self._line
        if pose is None or line is None or _is_near_line(cable, line, pose):
            return True
        former = self._former_line
        if self._mode is Mode.FOLLOWING or former is None or former.progress(pose) > FORMER_COUNTS:
            return False
        # What was followed since may have been something else, for all its length.
        return _is_near_line(cable, former, pose)

    def _command_without(self, seconds: float, pose: Pose | None) -> Command:
        """Return the command while no credible cable is observed."""
        settings = self._settings
        if self._mode in {Mode.WAITING, Mode.GIVEN_UP}:
            return STOP
        waited = self._clock.now - self._last_observed
        if waited <= HOLD_TIME:
            return self._command
        if self._mode is Mode.FOLLOWING:
            self._searched = 0.0
            self._remember()
        if waited <= HOLD_TIME + PAUSE or pose is None or self._line is None:
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
        wanted = self._line.relative_to(pose, sweep(progress))
        return self._guidance.steer(wanted, seconds, settings.search_speed)

    def _remember(self) -> None:
        """Choose the line to search along.

        What was lost again soon after it was found may have been a furrow or a shadow: then the
        search goes on along the line from before. A single observation is better than no line.
        """
        if self._line is None or self._memory.way >= PROVEN:
            self._former_line = self._line
            self._line = self._memory.line() or self._line or self._last_line


def _is_near_line(cable: CableLine, line: RememberedLine, pose: Pose) -> bool:
    """Return whether an observed cable may continue a line, by offset and heading at a pose."""
    expected, way = line.relative_to(pose), max(line.progress(pose), 0.0)
    turned = abs(math.remainder(cable.heading - expected.heading, math.pi))
    is_near = abs(cable.offset - expected.offset) < NEAR + GATE_GROWTH * way
    return is_near and turned < min(NEAR_TURNED + GATE_TURN * way, MOST_TURNED)
