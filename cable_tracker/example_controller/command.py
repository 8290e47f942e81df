"""Commands of a controller to its vehicle."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Command:
    """Command to the vehicle.

    Attributes
    ----------
    surge, heave : float
        Velocity forward and up [m/s].
    turn : float
        Rate of turn to the left [rad/s].
    """

    surge: float = 0.0
    turn: float = 0.0
    heave: float = 0.0


STOP = Command()
"""Stand still."""

HOLD_TIME = 0.4
"""Time for which the last command is held: a frame or two without an answer are usual [s]."""
