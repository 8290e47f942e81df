"""The working frame: reduced to the working width, and split into channels."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError
from cable_tracker.tracking.succession import check_levels

LEAST_ROWS = 3
"""Rows that a reduced frame needs: with fewer, no contour has anything around it."""

COLOURLESS = 3
"""A pixel whose chroma is no farther from grey has no colour."""

COLOURED_SHARE = 0.01
"""Minimum share of coloured pixels in a picture that counts as coloured."""


TEXTURE_WINDOW = 5
"""Side of the square over which gradients are averaged [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class WorkingFrame:
    """A frame ready to be measured.

    Attributes
    ----------
    picture : Image
        The frame, reduced; grey (H, W) or blue-green-red (H, W, 3).
    channels : array
        uint8, shape (H, W, 3); see `channels_of`.
    is_coloured : bool
        Whether `channels` hold luma and chroma (else grey and texture); at first, whether there is
        enough colour.
    has_chroma : bool
        Whether a single pixel has colour.
    zoom : float
        Pixels of the frame per pixel of the working image.
    """

    picture: Image
    channels: NDArray[np.uint8]
    is_coloured: bool
    has_chroma: bool
    zoom: float

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the working image."""
        return self.picture.shape[0], self.picture.shape[1]

    @property
    def grey(self) -> Image:
        """The picture in grey, uint8, shape (H, W)."""
        return self.picture if self.picture.ndim == 2 else _in_grey(self.picture)

    def measured_in(self, *, colour: bool) -> WorkingFrame:
        """Return the frame with the channels of colour, or of grey."""
        if colour == self.is_coloured:
            return self
        picture = self.picture
        if colour and picture.ndim == 2:
            picture = np.asarray(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
        elif not colour:
            picture = _in_grey(picture)
        return replace(self, channels=channels_of(picture), is_coloured=colour)


def _in_grey(picture: Image) -> Image:
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


def check_target_frame(image: Image, working_width: int) -> None:
    """Check shape and levels of a frame, and its size at a working width [px].

    Raises
    ------
    FrameError
        It cannot be used.
    """
    if not (image.ndim == 2 or (image.ndim == 3 and image.shape[2] == 3)):
        raise FrameError(
            "a picture has shape (height, width), or (height, width, 3) in colour, not"
            f" {image.shape}"
        )
    check_levels(image)
    height, width = image.shape[:2]
    if _reduced(width, height, working_width)[1] < LEAST_ROWS:
        raise FrameError(
            f"a frame of {width}x{height} px has hardly a row left at a working width of"
            f" {working_width} px; crop it or raise working_width"
        )


def _reduced(width: int, height: int, working_width: int) -> tuple[int, int]:
    """Return width and height of the working image [px]."""
    if width <= working_width:
        return width, height
    return working_width, round(height / (width / working_width))


def make_working_frame(image: Image, working_width: int) -> WorkingFrame:
    """Reduce a frame to the working width, and work out its channels.

    Parameters
    ----------
    image : Image
        uint8, grey (H, W) or blue-green-red (H, W, 3).
    working_width : int
        Wider frames are reduced to it [px].
    """
    height, width = image.shape[:2]
    zoom = 1.0
    small = image
    if width > working_width:
        zoom = width / working_width
        size = _reduced(width, height, working_width)
        small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    if small.ndim == 2:
        return WorkingFrame(small, channels_of(np.ascontiguousarray(small)), False, False, zoom)
    channels = channels_of(small)
    chroma = channels[::4, ::4, 1:].astype(np.int16) - 128
    if np.count_nonzero(np.abs(chroma) > COLOURLESS) > COLOURED_SHARE * chroma.size:
        return WorkingFrame(small, channels, True, True, zoom)
    least, most = int(channels[..., 1:].min()), int(channels[..., 1:].max())
    has_chroma = max(most - 128, 128 - least) > COLOURLESS
    return WorkingFrame(small, channels_of(_in_grey(small)), False, has_chroma, zoom)


def channels_of(image: Image) -> NDArray[np.uint8]:
    """Return three channels of a picture, uint8, shape (H, W, 3).

    Of a coloured one (H, W, 3), blue-green-red: luma and two chromas; of a grey one (H, W): grey,
    texture, and nothing.
    """
    smooth = cv2.blur(image, (3, 3))
    if image.ndim == 3:
        return np.asarray(cv2.cvtColor(smooth, cv2.COLOR_BGR2YCrCb), dtype=np.uint8)
    across, down = cv2.spatialGradient(smooth)
    gradient = cv2.add(cv2.convertScaleAbs(across), cv2.convertScaleAbs(down))
    texture = cv2.blur(gradient, (TEXTURE_WINDOW, TEXTURE_WINDOW))
    # The root spreads the many small gradients over more bins than the few large ones.
    rooted = cv2.LUT(texture, np.round(np.sqrt(np.arange(256) * 255.0)).astype(np.uint8))
    return np.asarray(cv2.merge((smooth, rooted, np.zeros_like(smooth))), dtype=np.uint8)
