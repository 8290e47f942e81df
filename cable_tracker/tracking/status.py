"""When a target is claimed, and when it is given up."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

LARGEST_STEP = 0.5
"""Share of the loss time that one frame counts for at most: however slow the camera, one frame does
not make a cable lost."""


class TrackingStatus(str, Enum):
    """How far the tracker may be trusted."""

    INITIALISING = "INITIALISING"
    """Nothing found yet: the particles are spread out and search."""

    TRACKING = "TRACKING"
    """The target is claimed; only now do state and covariance mean anything to a controller."""

    LOST = "LOST"
    """There was a target, and the image does not support it any more."""


# Statuses of a node that are no belief of its tracker.

REFUSED: Final = "REFUSED"
"""The frame could not be used."""

WARMING_UP: Final = "WARMING UP"
"""Its functions are being compiled; frames that come are not used."""

DISABLED: Final = "DISABLED"
"""The user has switched it off."""


@dataclass(frozen=True, slots=True)
class StatusMachine:
    """Hysteresis over what frame after frame speaks for. Never changed in place.

    Attributes
    ----------
    status : TrackingStatus
        Status that is published.
    time_towards_change : float
        Time for which consecutive frames supported leaving the present status [s].
    unclaimed_time : float
        Time since a target was last claimed, or since the search last began anew [s].
    """

    status: TrackingStatus = TrackingStatus.INITIALISING
    time_towards_change: float = 0.0
    unclaimed_time: float = 0.0

    @property
    def is_confirming(self) -> bool:
        """Whether a target is seen but not claimed yet, so that a search would lose it."""
        return self.status is not TrackingStatus.TRACKING and self.time_towards_change > 0.0

    def is_first_claim(self, memory_time: float) -> bool:
        """Tell whether a claim would be the first, or the first for long.

        `memory_time` is how long what was claimed is remembered [s].
        """
        return self.status is TrackingStatus.INITIALISING or self.unclaimed_time > memory_time

    def is_search_due(self, search_time: float) -> bool:
        """Tell whether nothing has been claimed or seen for so long that a search starts anew."""
        if self.status is TrackingStatus.TRACKING or self.is_confirming:
            return False
        return self.unclaimed_time >= search_time

    def after(
        self,
        *,
        supports_claim: bool,
        supports_keeping: bool,
        dt: float,
        confirmation_time: float,
        loss_time: float,
        contradicts_claim: bool = False,
    ) -> StatusMachine:
        """Return the status after one more frame.

        Parameters
        ----------
        supports_claim, supports_keeping : bool
            Whether the frame speaks for claiming a target, and for going on to claim it.
        dt : float
            Time since the frame before [s]. A frame counts for it, but against a claim for no more
            than half of the loss time.
        confirmation_time, loss_time : float
            How long frames must speak for a target before it is claimed, and against it before it
            is given up [s].
        contradicts_claim : bool
            Whether the frame speaks against what was claimed: the estimate is of something else, or
            nothing is in view. The loss time does not run then: no frame of it may pass for what
            was claimed.
        """
        if self.status is TrackingStatus.TRACKING:
            if contradicts_claim and not supports_keeping:
                return StatusMachine(TrackingStatus.LOST)
            return self._while_claimed(supports_keeping, dt, loss_time)
        return self._while_unclaimed(supports_claim, dt, confirmation_time)

    def _while_claimed(self, supports_keeping: bool, dt: float, loss_time: float) -> StatusMachine:
        if supports_keeping:
            return replace(self, time_towards_change=0.0, unclaimed_time=0.0)
        towards_change = self.time_towards_change + min(dt, LARGEST_STEP * loss_time)
        if towards_change >= loss_time:
            return StatusMachine(TrackingStatus.LOST)
        return replace(self, time_towards_change=towards_change)

    def _while_unclaimed(
        self, supports_claim: bool, dt: float, confirmation_time: float
    ) -> StatusMachine:
        unclaimed = self.unclaimed_time + dt
        if not supports_claim:
            return replace(self, time_towards_change=0.0, unclaimed_time=unclaimed)
        towards_change = self.time_towards_change + dt
        if towards_change >= confirmation_time:
            return StatusMachine(TrackingStatus.TRACKING)
        return replace(self, time_towards_change=towards_change, unclaimed_time=unclaimed)

    def confirm_with_next_frame(self) -> StatusMachine:
        """Return the status after a given initial state: one good frame confirms it."""
        return replace(self, time_towards_change=math.inf)

    def searched(self) -> StatusMachine:
        """Return the same status with the search begun anew."""
        return replace(self, time_towards_change=0.0, unclaimed_time=0.0)
