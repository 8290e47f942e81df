"""The frames of a soak test, over and over, as messages of a camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.sequences.bags.convert import ImageFormat, in_format, write_bag
from cable_tracker.sequences.frame import Frame, RawImage
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_compressed_image, make_image
from cable_tracker.stamps import NANOSECONDS

BEGINNING = 1_700_000_000 * NANOSECONDS
"""Time before the first frame, and of the first one of a replay [ns]."""

STEP = 40_000_000
"""Time between two frames [ns]."""

REPLAYED_FRAMES = 12
"""Number of frames of the bag for a replay."""


class SoakFrames:
    """Messages with the frames of a sequence, from the first again after the last.

    Parameters
    ----------
    frames : sequence of Frame
        8-bit grey or colour, all of one size.

    Attributes
    ----------
    compressed : bool
        Whether they are sent as JPEG.
    stamp : int
        Stamp of the last frame [ns].
    """

    def __init__(self, frames: Sequence[Frame]) -> None:
        self.compressed = False
        self.stamp = BEGINNING
        self._raw = frames
        self._jpegs = [in_format(frame, ImageFormat.JPEG) for frame in frames]
        self._number = 0

    @property
    def _frames(self) -> Sequence[Frame]:
        return self._jpegs if self.compressed else self._raw

    def next_message(self) -> Message:
        """Return the next frame."""
        self._number += 1
        self.stamp += STEP
        return self.message(self.stamp)

    def message(self, stamp: int) -> Message:
        """Return the present frame with any stamp [ns]."""
        return self._packed(self._frames[self._number % len(self._frames)], stamp)

    def tall_message(self) -> Message:
        """Return a next frame that is cut to half as wide as it is high."""
        self.stamp += STEP
        frame = self._raw[0]
        assert isinstance(frame.image, RawImage)
        width = frame.image.height // 2
        step = width * (frame.image.step // frame.image.width)
        rows = np.frombuffer(frame.image.data, np.uint8).reshape(frame.image.height, -1)
        data = memoryview(rows[:, :step].tobytes())
        narrow = replace(frame, image=replace(frame.image, width=width, step=step, data=data))
        return self._packed(
            in_format(narrow, ImageFormat.JPEG) if self.compressed else narrow, self.stamp
        )

    def _packed(self, frame: Frame, stamp: int) -> Message:
        image = frame.image
        if isinstance(image, RawImage):
            return make_image(MESSAGES, image, self.header(stamp))
        return make_compressed_image(MESSAGES, image, self.header(stamp))

    def header(self, stamp: int) -> Message:
        """Return the header of a message of the camera."""
        return make_header(MESSAGES, stamp, "camera")

    def short_bag(self, folder: Path) -> Path:
        """Return a bag with a few frames, written into a folder when first asked for."""
        path = folder / ("jpeg" if self.compressed else "raw")
        if not path.exists():
            some = enumerate(self._frames[:REPLAYED_FRAMES])
            write_bag(path, (replace(each, stamp=BEGINNING + n * STEP) for n, each in some))
        return path
