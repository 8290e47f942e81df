"""Whether odometry agrees with how the sea bed's texture moves."""

from __future__ import annotations

from cable_tracker.metric.sea_bed_texture import TextureMotion

CALM_PICTURES = 5
"""Number of pictures in a row that must agree with odometry after one that did not."""

REMEMBERED_PICTURES = 12
"""Number of pictures without texture for which the last one with some counts."""


class TextureGate:
    """Says by the sea bed's texture whether predictions may be used.

    Two pictures show at once what is wrong: odometry is believed until a picture speaks against it.
    """

    def __init__(self) -> None:
        self._calm = CALM_PICTURES
        self._unseen = REMEMBERED_PICTURES

    @property
    def verdict(self) -> bool | None:
        """Whether predictions may be used; None: there is too little texture to tell."""
        if self._unseen >= REMEMBERED_PICTURES:
            return None
        return self._calm >= CALM_PICTURES

    def take(self, motion: TextureMotion | None) -> None:
        """Take one picture into account; None: it showed too little."""
        if motion is None:
            self._unseen += 1
            return
        self._unseen = 0
        self._calm = self._calm + 1 if motion.agrees else 0
