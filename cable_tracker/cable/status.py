"""When a cable is claimed, and when it is given up."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from cable_tracker.cable.model.estimate import TrackingStatus
from cable_tracker.cable.parameters.parameters import TrackerParameters


@dataclass(frozen=True, slots=True)
class StatusMachine:
    """Hysteresis over what frame after frame speaks for. Never changed in place.

    Attributes
    ----------
    status : TrackingStatus
        What is claimed now.
    contrary_time : float
        How long the frames have spoken against the present status without a break [s].
    unclaimed_time : float
        How long no cable has been claimed, or since the last start from random [s].
    """

    status: TrackingStatus = TrackingStatus.INITIALISING
    contrary_time: float = 0.0
    unclaimed_time: float = 0.0

    @property
    def is_confirming(self) -> bool:
        """Whether a cable has been seen that is not claimed yet, so that a search would lose it."""
        return self.status is not TrackingStatus.TRACKING and self.contrary_time > 0.0

    def after(
        self, *, rises: bool, holds: bool, dt: float, parameters: TrackerParameters
    ) -> StatusMachine:
        """Return the status after one more frame.

        Parameters
        ----------
        rises, holds : bool
            Whether the frame speaks for claiming a cable, and for going on to claim one.
        dt : float
            Time since the frame before [s].
        parameters : TrackerParameters
            Times.
        """
        if self.status is TrackingStatus.TRACKING:
            return self._while_claimed(holds, dt, parameters)
        return self._while_unclaimed(rises, dt, parameters)

    def _while_claimed(
        self, holds: bool, dt: float, parameters: TrackerParameters
    ) -> StatusMachine:
        if holds:
            return replace(self, contrary_time=0.0, unclaimed_time=0.0)
        contrary = self.contrary_time + dt
        if contrary >= parameters.loss_time:
            return StatusMachine(TrackingStatus.LOST)
        return replace(self, contrary_time=contrary)

    def _while_unclaimed(
        self, rises: bool, dt: float, parameters: TrackerParameters
    ) -> StatusMachine:
        unclaimed = self.unclaimed_time + dt
        if not rises:
            return replace(self, contrary_time=0.0, unclaimed_time=unclaimed)
        contrary = self.contrary_time + dt
        if contrary >= parameters.confirmation_time:
            return StatusMachine(TrackingStatus.TRACKING)
        return replace(self, contrary_time=contrary, unclaimed_time=unclaimed)

    def expecting(self) -> StatusMachine:
        """Return the status of someone who was told where the cable is: one good frame confirms."""
        return replace(self, contrary_time=math.inf)

    def searched(self) -> StatusMachine:
        """Return the same status with the search begun anew."""
        return replace(self, contrary_time=0.0, unclaimed_time=0.0)
