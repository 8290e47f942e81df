"""Trackers to compare with: those of OpenCV, as far as the installed wheel has them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any, Protocol

import cv2
import numpy as np

from cable_tracker.arrays import Image, eight_bits
from cable_tracker.errors import FrameError
from cable_tracker.libraries import refusals_as
from cable_tracker.target.model.estimate import Box


class BoxTracker(Protocol):
    """Tracker of a box from frame to frame."""

    def start(self, image: Image, box: Box, stamp: int) -> Box | None:
        """Take what is in the box for the target; return the first claim; (H, W) or (H, W, 3)."""
        ...

    def update(self, image: Image, stamp: int) -> Box | None:
        """Return the box in the next frame; None where no target is claimed."""
        ...


LEAST_SIDE = 4
"""Shortest side of a box that a peer is given [px]: of less, some of them take minutes."""


def _whole(box: Box, image: Image) -> tuple[int, int, int, int]:
    """Return left, top, width and height in whole pixels of what is inside the picture.

    Raises
    ------
    FrameError
        Less than `LEAST_SIDE` of it is inside.
    """
    height, width = image.shape[:2]
    left, right = (min(max(round(side), 0), width) for side in box[::2])
    top, bottom = (min(max(round(side), 0), height) for side in box[1::2])
    if min(right - left, bottom - top) < LEAST_SIDE:
        raise FrameError(f"less than {LEAST_SIDE} px of the box are inside the picture")
    return left, top, right - left, bottom - top


class OpenCvTracker:
    """One of the `cv2.Tracker...` classes."""

    def __init__(self, make: Callable[[], Any]) -> None:
        self._make = make
        self._tracker: Any = None

    def start(self, image: Image, box: Box, stamp: int) -> Box | None:
        """Take what is in the box for the target; frames are (H, W) or (H, W, 3)."""
        self._tracker = None
        tracker, inside = self._make(), _whole(box, image)
        with refusals_as(FrameError, "the tracker of OpenCV refuses it"):
            tracker.init(_in_colour(image), inside)
        self._tracker = tracker
        return box

    def update(self, image: Image, stamp: int) -> Box | None:
        """Return the box in the next frame; None where the tracker says that it has none."""
        if self._tracker is None:
            return None
        with refusals_as(FrameError, "the tracker of OpenCV refuses it"):
            found, (left, top, width, height) = self._tracker.update(_in_colour(image))
        if not found:
            return None
        return float(left), float(top), float(left + width), float(top + height)


class CamShiftTracker:
    """CamShift on the back projection of a histogram of hues, or of grey levels."""

    LEAST_MEAN = 20.0
    """Back projection below which nothing is claimed, of 255."""

    def __init__(self) -> None:
        self._histogram: Image = np.empty(0)
        self._window = (0, 0, 1, 1)

    def start(self, image: Image, box: Box, stamp: int) -> Box | None:
        """Learn the hues of the inner ellipse of the box."""
        self._window = left, top, width, height = _whole(box, image)
        mask = np.zeros(image.shape[:2], np.uint8)
        centre, axes = (left + width // 2, top + height // 2), (width * 2 // 5, height * 2 // 5)
        cv2.ellipse(mask, centre, axes, 0, 0, 360, 255, -1)
        channel, limit = self._channel(image)
        histogram = cv2.calcHist([channel], [0], mask, [32], [0, limit])
        self._histogram = histogram * (255.0 / max(float(histogram.max()), 1.0))
        return box

    def update(self, image: Image, stamp: int) -> Box | None:
        """Return the box in the next frame."""
        if not self._histogram.size:
            return None
        channel, limit = self._channel(image)
        projection = cv2.calcBackProject([channel], [0], self._histogram, [0, limit], 1)
        criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1)
        _, window = cv2.CamShift(projection, self._window, criteria)
        left, top, width, height = (int(value) for value in window)
        if width < 2 or height < 2:
            return None
        self._window = (left, top, width, height)
        if projection[top : top + height, left : left + width].mean() < self.LEAST_MEAN:
            return None
        return float(left), float(top), float(left + width), float(top + height)

    @staticmethod
    def _channel(image: Image) -> tuple[Image, int]:
        image = eight_bits(image)
        if image.ndim == 2:
            return image, 256
        return np.ascontiguousarray(cv2.cvtColor(image, cv2.COLOR_BGR2HSV)[..., 0]), 180


def _in_colour(image: Image) -> Image:
    image = eight_bits(image)
    return image if image.ndim == 3 else cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)


OPENCV_TRACKERS = ("CSRT", "KCF", "MIL")


def _peers() -> dict[str, Callable[[], BoxTracker]]:
    peers: dict[str, Callable[[], BoxTracker]] = {}
    for name in OPENCV_TRACKERS:
        make = getattr(cv2, f"Tracker{name}_create", None)
        if make is not None:
            peers[name] = partial(OpenCvTracker, make)
    peers["CamShift"] = CamShiftTracker
    return peers


PEERS: Mapping[str, Callable[[], BoxTracker]] = MappingProxyType(_peers())
"""Peers by name; CSRT and KCF only where the wheel is opencv-contrib-python-headless before 5.0."""

MISSING_PEERS: tuple[str, ...] = tuple(name for name in OPENCV_TRACKERS if name not in PEERS)
"""Names of the peers that the installed OpenCV lacks."""
