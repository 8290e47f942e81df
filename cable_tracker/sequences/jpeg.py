"""Pictures as JPEG files, for topics and bags."""

from __future__ import annotations

import cv2

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError
from cable_tracker.sequences.frame import CompressedImage

OVERLAY_QUALITY = 80


def encode_jpeg(picture: Image, quality: int = OVERLAY_QUALITY) -> CompressedImage:
    """Compress a picture, uint8, grey or blue-green-red.

    Parameters
    ----------
    picture : Image
        Shape (H, W) or (H, W, 3).
    quality : int
        0..100.

    Raises
    ------
    FrameError
        OpenCV cannot encode it.
    """
    refusal = f"a picture of shape {picture.shape} cannot be encoded as JPEG"
    try:
        encoded, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
    except cv2.error as error:
        raise FrameError(refusal) from error
    if not encoded:
        raise FrameError(refusal)
    return CompressedImage("jpeg", memoryview(data.tobytes()))
