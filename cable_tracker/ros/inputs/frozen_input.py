"""Notices a camera that sends the same picture again and again."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.stamps import NANOSECONDS

LOOK_AT_EVERY = 16
"""Pixels apart that are compared first, each way; noise alone makes some of them differ."""


class FrozenInput:
    """Measures for how long the picture has been the same, by the stamps of the frames."""

    def __init__(self) -> None:
        self._picture: Image | None = None
        self._since = 0
        self._seconds = 0.0

    @property
    def seconds(self) -> float:
        """How long the last picture has been the same [s]."""
        return self._seconds

    @property
    def picture(self) -> Image | None:
        """The last picture, shape (H, W) or (H, W, 3)."""
        return self._picture

    def take(self, picture: Image, stamp: int) -> float:
        """Compare a frame with the one before; return for how long they have been the same [s].

        Parameters
        ----------
        picture : Image
            Shape (H, W) or (H, W, 3). Kept until the next one, and never written to.
        stamp : int
            Time of the frame [ns].
        """
        if self._picture is None or stamp < self._since or not same(self._picture, picture):
            self._since = stamp
        self._picture = picture
        self._seconds = (stamp - self._since) / NANOSECONDS
        return self._seconds

    def forget(self) -> None:
        """Begin anew."""
        self._picture = None
        self._seconds = 0.0


def same(picture: Image, other: Image) -> bool:
    """Tell whether two pictures, (H, W) or (H, W, 3), are the same in every pixel."""
    if picture.shape != other.shape or picture.dtype != other.dtype:
        return False
    sample = (slice(None, None, LOOK_AT_EVERY), slice(None, None, LOOK_AT_EVERY))
    return np.array_equal(picture[sample], other[sample]) and np.array_equal(picture, other)
