"""Turn the pixels of a message into pictures, and say precisely why one cannot be.

The names are those of sensor_msgs/image_encodings.hpp.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import Image, eight_bits
from cable_tracker.errors import FrameError
from cable_tracker.libraries import refusals_as
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.sequences.pictures.picture_header import (
    MAX_PIXELS,
    PICTURE_KINDS,
    read_picture_header,
)

_SMALLEST_BAYER = 3
_UNIT_LIMIT = 1.5
_COMPRESSED_KINDS = ("JPEG", "PNG")


@dataclass(frozen=True, slots=True)
class _PixelFormat:
    """How the pixels of one encoding lie in memory, and how OpenCV converts them.

    Attributes
    ----------
    dtype : str
        NumPy type of one number, without byte order.
    channels : int
        Numbers per pixel.
    to_grey, to_bgr : int or None
        OpenCV conversion code; None where there is nothing to convert.
    luma : int or None
        YUV 4:2:2 only: which of the two bytes of a pixel is Y.
    bayer : bool
        Whether neighbours carry different colours.
    """

    dtype: str
    channels: int
    to_grey: int | None
    to_bgr: int | None
    luma: int | None = None
    bayer: bool = False


def _grey(dtype: str) -> _PixelFormat:
    return _PixelFormat(dtype, 1, None, cv2.COLOR_GRAY2BGR)


def _bayer(dtype: str, to_grey: int, to_bgr: int) -> _PixelFormat:
    return _PixelFormat(dtype, 1, to_grey, to_bgr, bayer=True)


_BGR = {
    bits: _PixelFormat(dtype, 3, cv2.COLOR_BGR2GRAY, None)
    for bits, dtype in ((8, "u1"), (16, "u2"))
}
_RGB = {
    bits: _PixelFormat(dtype, 3, cv2.COLOR_RGB2GRAY, cv2.COLOR_RGB2BGR)
    for bits, dtype in ((8, "u1"), (16, "u2"))
}
_BGRA = _PixelFormat("u1", 4, cv2.COLOR_BGRA2GRAY, cv2.COLOR_BGRA2BGR)
_RGBA = _PixelFormat("u1", 4, cv2.COLOR_RGBA2GRAY, cv2.COLOR_RGBA2BGR)
_UYVY = _PixelFormat("u1", 2, None, cv2.COLOR_YUV2BGR_UYVY, luma=1)
_YUYV = _PixelFormat("u1", 2, None, cv2.COLOR_YUV2BGR_YUY2, luma=0)

# OpenCV names a Bayer pattern by the second row's second and third pixel, ROS by the first four.
_BAYER_CODES = {
    "rggb": (cv2.COLOR_BayerBG2GRAY, cv2.COLOR_BayerBG2BGR),
    "bggr": (cv2.COLOR_BayerRG2GRAY, cv2.COLOR_BayerRG2BGR),
    "gbrg": (cv2.COLOR_BayerGR2GRAY, cv2.COLOR_BayerGR2BGR),
    "grbg": (cv2.COLOR_BayerGB2GRAY, cv2.COLOR_BayerGB2BGR),
}

_FORMATS: dict[str, _PixelFormat] = {
    "mono8": _grey("u1"),
    "8UC1": _grey("u1"),
    "mono16": _grey("u2"),
    "16UC1": _grey("u2"),
    "32FC1": _grey("f4"),
    "bgr8": _BGR[8],
    "8UC3": _BGR[8],
    "bgr16": _BGR[16],
    "rgb8": _RGB[8],
    "rgb16": _RGB[16],
    "bgra8": _BGRA,
    "8UC4": _BGRA,
    "rgba8": _RGBA,
    **{f"bayer_{pattern}8": _bayer("u1", *codes) for pattern, codes in _BAYER_CODES.items()},
    **{f"bayer_{pattern}16": _bayer("u2", *codes) for pattern, codes in _BAYER_CODES.items()},
    "yuv422": _UYVY,
    "uyvy": _UYVY,
    "yuv422_yuy2": _YUYV,
    "yuyv": _YUYV,
}

ENCODINGS: tuple[str, ...] = tuple(_FORMATS)
"""Names of all encodings that can be decoded."""


def _checked_format(image: RawImage) -> _PixelFormat:
    """Return the format of an image whose encoding, size, step and amount of data fit together.

    Of the pixels themselves nothing is read. The last row may lack its padding.

    Raises
    ------
    FrameError
        They do not; the message names the field that is wrong.
    """
    size = f"{image.width} x {image.height}"
    if image.width <= 0 or image.height <= 0:
        raise FrameError(f"the image has no pixels ({size})")
    pixel_format = _FORMATS.get(image.encoding)
    if pixel_format is None:
        raise FrameError(
            f"unknown encoding {image.encoding[:40]!r}; known are {', '.join(ENCODINGS)}"
        )
    if image.width * image.height > MAX_PIXELS:
        raise FrameError(f"the image claims {size} pixels, more than the {MAX_PIXELS} allowed")
    if pixel_format.luma is not None and image.width % 2:
        raise FrameError(f"encoding {image.encoding} needs an even width, not {image.width}")
    if pixel_format.bayer and min(image.width, image.height) < _SMALLEST_BAYER:
        raise FrameError(f"an image of {size} pixels is too small for encoding {image.encoding}")
    row = image.width * pixel_format.channels * np.dtype(pixel_format.dtype).itemsize
    if image.step < row:
        raise FrameError(
            f"step {image.step} is too small: a row of {image.width} pixels in {image.encoding}"
            f" takes {row} bytes"
        )
    whole = image.height * image.step
    if image.data.nbytes < whole - image.step + row:
        raise FrameError(
            f"the data is too short: {image.data.nbytes} bytes instead of {whole}"
            f" ({image.height} rows of {image.step} bytes)"
        )
    if image.data.nbytes > whole:
        raise FrameError(
            f"the data is too long: {image.data.nbytes} bytes instead of {whole}"
            f" ({image.height} rows of {image.step} bytes)"
        )
    return pixel_format


def check_image(image: RawImage | CompressedImage) -> None:
    """Check that an image can be decoded: a raw one by its layout, a compressed one by doing it.

    Raises
    ------
    FrameError
        The image cannot be decoded.
    """
    # What decodes a missing image is told why there is none.
    if isinstance(image, RawImage) and not image.missing:
        _checked_format(image)
    else:
        decode_grey(image)


def _pixels(image: RawImage, pixel_format: _PixelFormat) -> Image:
    """View the pixels as (H, W) or (H, W, C) in the machine's byte order, without the padding."""
    dtype = np.dtype(pixel_format.dtype).newbyteorder(">" if image.is_bigendian else "<")
    shape: tuple[int, ...] = (image.height, image.width)
    strides: tuple[int, ...] = (image.step, pixel_format.channels * dtype.itemsize)
    if pixel_format.channels > 1:
        shape, strides = (*shape, pixel_format.channels), (*strides, dtype.itemsize)
    view: Image = np.ndarray(shape, dtype, buffer=image.data, strides=strides)
    return view.astype(dtype.newbyteorder("="), copy=False)


def _converted(pixels: Image, code: int | None) -> Image:
    """Convert pixels, and bring 16-bit and float ones to float32 in 0..255."""
    if code is not None:
        with refusals_as(FrameError, "the pixels cannot be converted"):
            pixels = np.asarray(cv2.cvtColor(np.require(pixels, requirements=["C", "A"]), code))
    if pixels.dtype == np.float32:
        return _float_to_255(pixels)
    if pixels.dtype == np.uint16:
        return pixels.astype(np.float32) / np.float32(257.0)
    return pixels


def _float_to_255(pixels: Image) -> NDArray[np.float32]:
    if not np.isfinite(pixels).all():
        raise FrameError("the 32FC1 image holds pixels that are not finite numbers")
    scale = np.float32(1.0 if pixels.max() > _UNIT_LIMIT else 255.0)
    return np.clip(pixels * scale, np.float32(0.0), np.float32(255.0))


@cache
def _silence_opencv() -> None:
    """Switch off OpenCV's own messages; what goes wrong is said in our exceptions."""
    # OpenCV 4 has cv2.setLogLevel, OpenCV 5 only cv2.utils.logging.
    opencv = cast("Any", cv2)
    if hasattr(opencv, "setLogLevel"):
        opencv.setLogLevel(0)
    else:
        opencv.utils.logging.setLogLevel(0)


def decode_picture_file(
    data: memoryview, flags: int, kinds: Sequence[str] = PICTURE_KINDS
) -> Image:
    """Decode a whole picture file; what it says of how the camera was turned is not followed.

    What a PNM says is white becomes the greatest level of its 8 or 16 bits: a camera of 10 or 12
    bits says 1023 or 4095.

    Parameters
    ----------
    data : memoryview
        All bytes of the file.
    flags : int
        OpenCV's `IMREAD_*`.
    kinds : sequence of str
        Kinds that are decoded; see `read_picture_header`.

    Raises
    ------
    FrameError
        It is no such file, or damaged.
    """
    header = read_picture_header(data, kinds)
    kind = header.kind
    _silence_opencv()
    try:
        # Labels and camera calibrations refer to the pixels as stored, not as turned by EXIF.
        flags |= cv2.IMREAD_IGNORE_ORIENTATION
        picture: Any = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    except cv2.error as error:
        raise FrameError(f"the {kind} is damaged and cannot be decoded") from error
    if picture is None or not picture.size:
        raise FrameError(f"the {kind} is damaged and cannot be decoded")
    decoded = np.asarray(picture)
    return decoded if header.white is None else _with_white(decoded, header.white)


def _with_white(picture: Image, white: int) -> Image:
    """Multiply levels so that one, and all above it, becomes the greatest of the dtype."""
    greatest = np.iinfo(picture.dtype).max
    if white == greatest:
        return picture
    levels = np.minimum(np.arange(greatest + 1), white)
    return np.rint(levels * (greatest / white)).astype(picture.dtype)[picture]


def _mosaic_of(image: CompressedImage) -> RawImage | None:
    """Return the mosaic of a Bayer camera that was compressed as it is; None: it is a picture.

    That is what image_transport makes of one: ``bayer_rggb8; jpeg compressed``.
    """
    encoding = image.format.partition(";")[0].strip()
    pixel_format = _FORMATS.get(encoding)
    if pixel_format is None or not pixel_format.bayer:
        return None
    pixels = decode_picture_file(image.data, cv2.IMREAD_UNCHANGED, _COMPRESSED_KINDS)
    if pixels.ndim != 2:
        return None
    # Of 16 bits JPEG leaves 8.
    return raw_from_array(pixels, f"{encoding.rstrip('0123456789')}{8 * pixels.itemsize}")


def _decompressed(image: CompressedImage, flags: int) -> Image:
    """Decode the picture of a compressed image; a PNG of 16 bits keeps the steps of its levels."""
    depth = cv2.IMREAD_ANYDEPTH
    return _converted(decode_picture_file(image.data, flags | depth, _COMPRESSED_KINDS), None)


def decode_grey(image: RawImage | CompressedImage) -> Image:
    """Decode an image to grey.

    * Colour becomes grey by OpenCV's weights (0.299 R + 0.587 G + 0.114 B); of YUV the Y bytes are
      taken as they are; a Bayer pattern is interpolated, also that of a compressed image whose
      format names it.
    * 16-bit values, also those of a compressed image, are divided by 257, so that white is 255.
    * 32FC1: if any value is above 1.5 the values are taken as 0..255, otherwise as 0..1. What lies
      outside the range is clipped.

    Parameters
    ----------
    image : RawImage or CompressedImage
        Recorded or received image.

    Returns
    -------
    Image
        Shape (H, W); uint8, or float32 in 0..255 for 16-bit and float encodings. For mono8 it is a
        read-only view of the image's own data if that is read-only; copy before writing to it.

    Raises
    ------
    FrameError
        The image cannot be decoded; the message says why.
    """
    return _decoded(image, in_grey=True)


def decode_bgr(image: RawImage | CompressedImage) -> Image:
    """Decode an image to colour of eight bits.

    Returns
    -------
    Image
        Shape (H, W, 3), uint8, blue-green-red. May be a view of the image's own data.

    Raises
    ------
    FrameError
        The image cannot be decoded; the message says why.
    """
    return eight_bits(decode_bgr_levels(image))


def decode_bgr_levels(image: RawImage | CompressedImage) -> Image:
    """Decode an image to colour, with the steps that its levels have.

    Returns
    -------
    Image
        Shape (H, W, 3), blue-green-red: uint8, or float32 in 0..255 of deeper images. May be a view
        of the image's own data.

    Raises
    ------
    FrameError
        The image cannot be decoded; the message says why.
    """
    return _decoded(image, in_grey=False)


def _decoded(image: RawImage | CompressedImage, *, in_grey: bool) -> Image:
    if image.missing:
        # The recording gives nothing of it, and says why.
        raise FrameError(image.missing)
    if isinstance(image, CompressedImage):
        mosaic = _mosaic_of(image)
        if mosaic is None:
            return _decompressed(image, cv2.IMREAD_GRAYSCALE if in_grey else cv2.IMREAD_COLOR)
        image = mosaic
    pixel_format = _checked_format(image)
    pixels = _pixels(image, pixel_format)
    if in_grey and pixel_format.luma is not None:
        return pixels[:, :, pixel_format.luma]
    return _converted(pixels, pixel_format.to_grey if in_grey else pixel_format.to_bgr)


def raw_from_array(picture: Image, encoding: str) -> RawImage:
    """Wrap a picture as an uncompressed image; no pixel is copied if it is contiguous.

    Parameters
    ----------
    picture : Image
        Shape (H, W) or (H, W, C), in the machine's byte order, as `encoding` asks for.
    encoding : str
        One of `ENCODINGS`.

    Raises
    ------
    FrameError
        Shape or type of the picture do not fit the encoding.
    """
    pixel_format = _FORMATS.get(encoding)
    if pixel_format is None:
        raise FrameError(f"unknown encoding {encoding!r}; known are {', '.join(ENCODINGS)}")
    channels = picture.shape[2] if picture.ndim == 3 else 1
    if (
        picture.ndim not in (2, 3)
        or channels != pixel_format.channels
        or picture.dtype != np.dtype(pixel_format.dtype)
    ):
        raise FrameError(
            f"a picture of shape {picture.shape} and type {picture.dtype} is no {encoding}"
        )
    little = np.ascontiguousarray(picture, dtype=picture.dtype.newbyteorder("<"))
    height, width = picture.shape[:2]
    image = RawImage(
        encoding=encoding,
        height=height,
        width=width,
        step=width * channels * picture.dtype.itemsize,
        is_bigendian=False,
        data=little.reshape(-1).view(np.uint8).data,
    )
    _checked_format(image)
    return image
