"""Pictures as JPEG and PNG, for topics, bags and files."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.errors import FrameError
from cable_tracker.libraries import refusals_as
from cable_tracker.sequences.frame import CompressedImage

OVERLAY_QUALITY = 80


def png_bytes(picture: Image) -> bytes:
    """Encode a picture, uint8, shape (H, W) or (H, W, 3), blue-green-red, as PNG.

    Raises
    ------
    FrameError
        OpenCV cannot encode it.
    """
    return _encoded(picture, "PNG", ())


def jpeg_bytes(picture: Image, quality: int = OVERLAY_QUALITY) -> bytes:
    """Encode a picture as JPEG.

    Parameters
    ----------
    picture : Image
        uint8, grey or blue-green-red, shape (H, W) or (H, W, 3).
    quality : int
        0..100.

    Raises
    ------
    FrameError
        OpenCV cannot encode it.
    """
    return _encoded(picture, "JPEG", (cv2.IMWRITE_JPEG_QUALITY, quality))


def encode_jpeg(picture: Image, quality: int = OVERLAY_QUALITY) -> CompressedImage:
    """Compress a picture for a message; see `jpeg_bytes`."""
    return CompressedImage("jpeg", memoryview(jpeg_bytes(picture, quality)))


def after_jpeg(picture: Image, quality: int) -> Image:
    """Return a grey picture, uint8, shape (H, W), after JPEG compression of a quality, 0..100."""
    data = np.frombuffer(jpeg_bytes(picture, quality), np.uint8)
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_GRAYSCALE))


def _encoded(picture: Image, kind: str, options: Sequence[int]) -> bytes:
    refusal = f"a picture of shape {picture.shape} cannot be encoded as {kind}"
    with refusals_as(FrameError, refusal):
        encoded, data = cv2.imencode(f".{kind.lower()}", picture, options)
    if not encoded:
        raise FrameError(refusal)
    return data.tobytes()
