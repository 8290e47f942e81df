"""Compares the sea bed's motion in the image with the one that odometry predicts.

Corners of the sea bed's texture in the picture before are found again in this one, and compared
with where the predicted homography takes them. This asks neither the cable nor the filter, so that
odometry can be judged before a cable is found, and cannot be drawn along by a prediction. Whether
predictions may be used follows from several pictures (`TextureGate`).

References
----------
J. Shi and C. Tomasi (1994), "Good features to track": the corners.
J.-Y. Bouguet (2000), "Pyramidal implementation of the Lucas Kanade feature tracker".
Z. Kalal, K. Mikolajczyk and J. Matas (2010), "Forward-backward error": which of them were found.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, FloatArray, Image, eight_bits
from cable_tracker.tracking.image_frame import image_to_pixel, pixel_to_image
from cable_tracker.tracking.level_gain import amplified, byte_gain
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH

MOST_CORNERS, FEWEST_CORNERS = 60, 12
"""Corners looked for, and how many it takes for a judgement."""

CORNER_QUALITY = 0.02
"""Weakest corner, as a share of the strongest one's strength."""

CORNER_DISTANCE, CORNER_BLOCK = 10, 7
"""Least distance between corners, and side of the square that is looked at for each [px]."""

EDGE = 8
"""Corners nearer to the edge of the picture, before or after, are not compared [px]."""

WINDOW, PYRAMID_LEVELS = (15, 15), 2
"""Window that is compared around each corner [px], and number of times the picture is halved."""

STEPS, PRECISION = 15, 0.02
"""Limits of the search for a corner: number of steps, and their least length [px]."""

WAY_BACK = 0.5
"""A corner was found if the way back ends so near to where it began [px]."""

NOISE = 1.0
"""Median error of sound predictions, by the bottom's relief and by the search itself [px of the
reference width]."""

ALLOWED_SHARE = 0.4
"""Share of the predicted way by which a prediction may be off besides: it still takes most of the
motion away then."""

CALM_PICTURES = 5
"""Number of pictures in a row that must agree with odometry after one that did not."""

REMEMBERED_PICTURES = 12
"""Number of pictures without texture for which the last one with some counts."""


@dataclass(frozen=True, slots=True)
class TextureMotion:
    """How corners moved, beside how they were predicted to.

    Attributes
    ----------
    error : float
        Median distance of the corners from where they were predicted; infinite if most were not
        found again [px of the reference width].
    length : float
        Median length of the predicted ways [px of the reference width].
    """

    error: float
    length: float

    @property
    def agrees(self) -> bool:
        """Whether the prediction is better than none."""
        return self.excess <= ALLOWED_SHARE * self.length

    @property
    def excess(self) -> float:
        """Part of the error that exceeds the noise [px of the reference width]."""
        return max(self.error - NOISE, 0.0)


class SeaBedTexture:
    """Compares each picture with the one before.

    Attributes
    ----------
    before : Image or None
        The last picture, grey levels, shape (H, W); set it to one that is not compared itself.
    """

    def __init__(self) -> None:
        self.before: Image | None = None

    def __deepcopy__(self, _memo: dict[int, object]) -> SeaBedTexture:
        # A picture never changes and may be large: copies share it.
        return copy(self)

    def compare(self, image: Image, mapping: FloatArray | None) -> TextureMotion | None:
        """Keep a picture, and return how it differs from the one before; None: unknown.

        Parameters
        ----------
        image : Image
            Grey levels, uint8 or float32 (0..255), shape (H, W).
        mapping : FloatArray or None
            The predicted homography from the picture before to this one, shape (3, 3), for points
            of the image frame [px]; None: there is no prediction.
        """
        before = None if self.before is None else _reduced(self.before)
        now = _reduced(image)
        self.before = now
        if before is None or mapping is None or before.shape != now.shape:
            return None
        before, now = in_bytes(before, now)
        scale = now.shape[1] / image.shape[1]
        zoom = np.diag([scale, scale, 1.0])
        starts, predicted = _corners(before, zoom @ mapping @ np.linalg.inv(zoom))
        if len(starts) < FEWEST_CORNERS:
            return None
        # A narrow picture is not enlarged.
        unit = REFERENCE_WIDTH / now.shape[1]
        length = unit * float(np.median(np.hypot(*(predicted - starts).T)))
        ends, is_found = _found_again(before, now, starts, predicted)
        if 2 * is_found.sum() < FEWEST_CORNERS:
            return TextureMotion(np.inf, length)
        errors = np.hypot(*(ends - predicted)[is_found].T)
        return TextureMotion(unit * float(np.median(errors)), length)


def _reduced(image: Image) -> Image:
    """Return a picture of the reference width, or as it is if it is narrower; levels 0..255."""
    height, width = image.shape
    if width > REFERENCE_WIDTH:
        size = (round(REFERENCE_WIDTH), max(1, round(height * REFERENCE_WIDTH / width)))
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    if image.dtype == np.uint8:
        return image
    levels: Image = np.clip(np.nan_to_num(image), 0.0, 255.0)
    return levels


def in_bytes(before: Image, now: Image) -> tuple[Image, Image]:
    """Return two pictures in 8 bits, both amplified alike if they are deeper and dim.

    In the few grey levels of a camera of 10 bits whose counts are sent as mono16, the corners that
    are found are those of the rounding, and stay where they are while the sea bed moves.

    Parameters
    ----------
    before, now : Image
        Levels 0..255, finite, uint8 or float32, shape (H, W).
    """
    # The gain of the pair alone: what lights change during a dive neither hides nor blinds it.
    gain = min(byte_gain(before), byte_gain(now))
    return eight_bits(amplified(before, gain)), eight_bits(amplified(now, gain))


def _corners(picture: Image, mapping: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return corners and where a homography takes them, (N, 2) each: columns and rows [px]."""
    found = cv2.goodFeaturesToTrack(
        picture, MOST_CORNERS, CORNER_QUALITY, CORNER_DISTANCE, blockSize=CORNER_BLOCK
    )
    if found is None:
        return np.empty((0, 2)), np.empty((0, 2))
    starts = found.reshape(-1, 2).astype(np.float64)
    size = (picture.shape[1], picture.shape[0])
    points = np.column_stack((pixel_to_image(starts, size), np.ones(len(starts))))
    mapped = points @ mapping.T
    with np.errstate(divide="ignore", invalid="ignore"):
        predicted = image_to_pixel(mapped[:, :2] / mapped[:, 2:], size)
    far = np.array(size) - 1 - EDGE
    both = np.stack((starts, predicted))
    inside = ((both >= EDGE) & (both <= far)).all(axis=(0, 2)) & (mapped[:, 2] > 0.0)
    return starts[inside], predicted[inside]


def _found_again(
    before: Image, now: Image, starts: FloatArray, predicted: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return where corners (N, 2) are now, and which of them were really found (N,)."""
    ends, is_seen = _followed(before, now, starts, predicted)
    back, is_seen_back = _followed(now, before, ends, starts)
    return ends, is_seen & is_seen_back & (np.hypot(*(back - starts).T) <= WAY_BACK)


def _followed(
    before: Image, now: Image, starts: FloatArray, guesses: FloatArray
) -> tuple[FloatArray, BoolArray]:
    ends, status, _ = cv2.calcOpticalFlowPyrLK(
        before,
        now,
        np.ascontiguousarray(starts[:, None, :], np.float32),
        np.array(guesses[:, None, :], np.float32, order="C"),
        winSize=WINDOW,
        maxLevel=PYRAMID_LEVELS,
        criteria=(cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, STEPS, PRECISION),
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    return ends[:, 0].astype(np.float64), status[:, 0] > 0


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
