"""Watches an input that may fall silent, or show the same picture again and again."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.node_parameter_tables import CameraRuntimeParameters
from cable_tracker.ros.health.diagnostics import FROZEN_INPUT, STALE_INPUT
from cable_tracker.stamps import NANOSECONDS

LOOK_AT_EVERY = 16
"""Pixels apart that are compared first, each way; noise alone makes some of them differ."""


def same(picture: Image, other: Image) -> bool:
    """Tell whether two pictures, (H, W) or (H, W, 3), are the same in every pixel."""
    if picture.shape != other.shape or picture.dtype != other.dtype:
        return False
    sample = (slice(None, None, LOOK_AT_EVERY), slice(None, None, LOOK_AT_EVERY))
    return np.array_equal(picture[sample], other[sample]) and np.array_equal(picture, other)


class InputWatch:
    """Says whether the frames can be relied on: STALE INPUT, FROZEN INPUT, or neither.

    Parameters
    ----------
    now : float
        Time on a monotonic clock [s]. A camera that never sends is no better than one that has
        stopped.

    Attributes
    ----------
    timeout : float
        Time without a usable frame that makes the input stale [s].
    picture : Image or None
        The last picture, shape (H, W) or (H, W, 3).
    same_for : float
        How long the picture has been the same, by the stamps of the frames [s].
    """

    def __init__(self, now: float) -> None:
        self.timeout = 0.0
        self.picture: Image | None = None
        self.same_for = 0.0
        self._frozen_timeout = 0.0
        self._maximum_gap = math.inf
        self._last_usable = now
        self._is_stale = False
        self._is_frozen = False
        self._since = self._last = 0

    def configure(self, parameters: CameraRuntimeParameters, maximum_gap: float) -> None:
        """Take other time-outs, and the longest pause between frames that the filter bears [s]."""
        self.timeout = parameters.input_timeout
        self._frozen_timeout = parameters.frozen_timeout
        self._maximum_gap = maximum_gap

    @property
    def status(self) -> str:
        """STALE INPUT or FROZEN INPUT; empty where neither holds."""
        if self._is_stale:
            return STALE_INPUT
        return FROZEN_INPUT if self._is_frozen else ""

    def restart(self, now: float) -> None:
        """Let the time of silence begin now, on the monotonic clock [s]."""
        self._last_usable = now

    def note_usable(self, now: float) -> None:
        """Note that a usable frame came: a silence ends."""
        self._is_stale = False
        self._last_usable = now

    def falls_silent(self, now: float) -> bool:
        """Return whether the input has just become stale; once for each silence."""
        if self._is_stale or now - self._last_usable <= self.timeout:
            return False
        self._is_stale = True
        return True

    def is_frozen(self, picture: Image, stamp: int) -> bool:
        """Tell whether the picture has been the same for too long.

        A pause or a jump of the clock adds nothing: of that time no frame has told.

        Parameters
        ----------
        picture : Image
            Shape (H, W) or (H, W, 3). Kept until the next one, and never written to.
        stamp : int
            Time of the frame [ns].
        """
        if self.picture is None or stamp < self._since or not same(self.picture, picture):
            self._since = stamp
        elif stamp - self._last > self._maximum_gap * NANOSECONDS:
            self._since += stamp - self._last
        self.picture, self._last = picture, stamp
        self.same_for = (stamp - self._since) / NANOSECONDS
        return 0.0 < self._frozen_timeout <= self.same_for

    def note_frozen(self, *, is_frozen: bool) -> bool:
        """Note whether the last frame was frozen; return whether the picture has just frozen."""
        has_just_frozen = is_frozen and not self._is_frozen
        self._is_frozen = is_frozen
        return has_just_frozen
