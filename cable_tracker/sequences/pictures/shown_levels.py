"""Pictures as people see them: those of deep cameras made so bright that something is seen."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import Image, eight_bits
from cable_tracker.sequences.encodings import decode_bgr_levels
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.tracking.level_gain import (
    LARGEST_GAIN,
    USUAL,
    amplified,
    level_range,
)

EYES = 3.0
"""What is dim is made so many times brighter for people than for measuring."""

STAND_IN_SIZE = (320, 240)
"""Width and height of the picture for a frame that cannot be shown [px]."""

DARK = 40
"""Its grey level."""


def shown_levels(picture: Image) -> Image:
    """Return a picture of eight bits for people to look at.

    One of finer steps that uses few of its levels is amplified, more than for measuring
    (`level_gain`) and steplessly: each picture by itself, a dive does not flicker. Bright parts
    are not cut off for it.

    Parameters
    ----------
    picture : Image
        Finite levels 0..255, shape (H, W) or (H, W, 3). That of uint8 is returned itself.
    """
    if picture.dtype == np.uint8:
        return picture
    low, high = level_range(picture)
    if high <= low:
        return eight_bits(picture)
    share = USUAL / (high - low)
    # Without a step where it begins: what uses its levels is shown as it is.
    wanted = min(share * min(share, EYES), 255.0 / high)
    return eight_bits(amplified(picture, min(max(wanted, 1.0), EYES * LARGEST_GAIN)))


def decode_shown(image: RawImage | CompressedImage) -> Image:
    """Decode an image to colour as `decode_bgr` does, but as `shown_levels` shows it.

    Raises
    ------
    FrameError
        The image cannot be decoded; the message says why.
    """
    return shown_levels(decode_bgr_levels(image))


def stand_in(size: tuple[int, int] = STAND_IN_SIZE) -> Image:
    """Return the picture for a frame that cannot be shown: dark, uint8, grey, shape (H, W).

    Parameters
    ----------
    size : (int, int)
        Width and height, that of the frames if it is known [px].
    """
    width, height = size
    return np.full((height, width), DARK, np.uint8)
