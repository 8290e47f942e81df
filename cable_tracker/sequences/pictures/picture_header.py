"""Header of a picture file, read with Pillow before anything is decoded.

A picture file of a few kilobytes can ask for gigabytes of pixels, and OpenCV decodes a truncated
JPEG to a half grey picture without complaint. Both are found here. The pixels are then decoded by
OpenCV, for Pillow has no colour of 16 bits a channel.
"""

from __future__ import annotations

import io
import struct
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PIL.BmpImagePlugin import BmpImageFile
from PIL.ImageFile import ImageFile
from PIL.JpegImagePlugin import JpegImageFile
from PIL.PngImagePlugin import PngImageFile
from PIL.PpmImagePlugin import PpmImageFile
from PIL.TiffImagePlugin import ImageFileDirectory_v2

from cable_tracker.errors import FrameError

MAX_PIXELS = 64_000_000
"""Larger pictures are refused; no camera on a vehicle makes them, a damaged header does."""

_JPEG_SCAN, _JPEG_END = b"\xff\xda", b"\xff\xd9"
_PNG_END = b"IEND\xae\x42\x60\x82"
_TIFF_WIDTH, _TIFF_HEIGHT = 256, 257
_LARGEST_BYTE = 255
_REFUSALS = (
    ArithmeticError, AttributeError, EOFError, LookupError, OSError, SyntaxError, TypeError,
    ValueError, struct.error,
)  # fmt: skip
"""Exceptions that Pillow raises for a damaged file."""

# Pillow warns of damaged notes (EXIF, TIFF tags), which say nothing of the pixels.
warnings.filterwarnings("ignore", module=r"PIL\.")


@dataclass(frozen=True, slots=True)
class PictureHeader:
    """Kind and size of a picture file.

    Attributes
    ----------
    kind : str
        JPEG, PNG, BMP, TIFF or PNM.
    width, height : int
        Size as stored, not turned by EXIF [px].
    white : int or None
        Brightest level of what OpenCV decodes, where the file says it: a PNM may have any. None: it
        is the greatest of 8 or 16 bits.
    """

    kind: str
    width: int
    height: int
    white: int | None = None


def _check_jpeg_end(data: bytes) -> None:
    # A thumbnail has an end of its own, before the scan of the picture; within a scan is none.
    if data.rfind(_JPEG_END) < data.rfind(_JPEG_SCAN):
        raise FrameError("the JPEG is truncated: its end is missing")


def _check_png(data: bytes) -> None:
    if _PNG_END not in data:
        raise FrameError("the PNG is truncated: its end is missing")
    try:
        PngImageFile(io.BytesIO(data)).verify()
    except _REFUSALS as error:
        raise FrameError("the PNG is damaged: a checksum is wrong") from error


def _tiff_size(data: bytes) -> tuple[int, int]:
    # The directory alone: Pillow has no pixels of three times 16 bits, which OpenCV decodes.
    directory = ImageFileDirectory_v2(data[:8])
    stream = io.BytesIO(data)
    stream.seek(directory.next)
    directory.load(stream)
    half = "<H" if data.startswith(b"II") else ">H"
    (count,) = struct.unpack_from(half, data, directory.offset)
    first = directory.offset + 2
    tags = [struct.unpack_from(half, data, first + 12 * entry)[0] for entry in range(count)]
    if tags.count(_TIFF_WIDTH) != 1 or tags.count(_TIFF_HEIGHT) != 1:
        raise ValueError("not one size; OpenCV might take the one that is not checked")
    return int(directory[_TIFF_WIDTH]), int(directory[_TIFF_HEIGHT])


def _pnm_white(data: bytes) -> int | None:
    """Return the brightest level of a PNM as it is decoded; bitmaps have black and white alone.

    OpenCV brings levels that are written as digits to 8 bits, and leaves all others as they are.
    """
    decoder, _, _, arguments = PpmImageFile(io.BytesIO(data)).tile[0]
    # The raw decoder reads bits, or levels of all of 8 or 16 bits.
    white = arguments[1] if decoder != "raw" and isinstance(arguments, tuple) else None
    is_scaled = decoder == "ppm_plain" and white is not None and white <= _LARGEST_BYTE
    return None if is_scaled else white


def _size_by(reader: type[ImageFile]) -> Callable[[bytes], tuple[int, int]]:
    # `Image.open` would let a file choose among some forty formats, and has its own limit of size.
    return lambda data: reader(io.BytesIO(data)).size


_KINDS: tuple[tuple[bytes, str, Callable[[bytes], tuple[int, int]]], ...] = (
    (b"\xff\xd8\xff", "JPEG", _size_by(JpegImageFile)),
    (b"\x89PNG\r\n\x1a\n", "PNG", _size_by(PngImageFile)),
    (b"BM", "BMP", _size_by(BmpImageFile)),
    (b"II*\0", "TIFF", _tiff_size),
    (b"MM\0*", "TIFF", _tiff_size),
    *((b"P%d" % number, "PNM", _size_by(PpmImageFile)) for number in range(1, 7)),
)
PICTURE_KINDS = tuple(dict.fromkeys(kind for _, kind, _ in _KINDS))
"""Kinds of pictures that are read."""

_CHECKS: dict[str, Callable[[bytes], None]] = {"JPEG": _check_jpeg_end, "PNG": _check_png}


def _recognise(data: bytes, kinds: Sequence[str]) -> tuple[str, Callable[[bytes], tuple[int, int]]]:
    for magic, kind, read_size in _KINDS:
        if data.startswith(magic):
            if kind not in kinds:
                raise FrameError(f"pictures here must be {' or '.join(kinds)}, not {kind}")
            return kind, read_size
    others = ", ".join(kinds[:-1])
    raise FrameError(f"the data is no picture: neither {others} nor {kinds[-1]} by its first bytes")


def read_picture_header(data: memoryview, kinds: Sequence[str] = PICTURE_KINDS) -> PictureHeader:
    """Read kind and size of a whole picture file, and check that it is all there.

    Parameters
    ----------
    data : memoryview
        All bytes of the file.
    kinds : sequence of str
        Kinds that may come here, at least two of `PICTURE_KINDS`.

    Raises
    ------
    FrameError
        No bytes, not a picture of these kinds, a damaged header, no pixels, more than `MAX_PIXELS`
        pixels, or a JPEG or PNG whose end is missing, or a PNG with a wrong checksum.
    """
    if not len(data):
        raise FrameError("the picture holds no bytes")
    content = bytes(data)
    kind, read_size = _recognise(content, kinds)
    try:
        width, height = read_size(content)
        white = _pnm_white(content) if kind == "PNM" else None
    except _REFUSALS as error:
        raise FrameError(f"the header of the {kind} is damaged") from error
    if width <= 0 or height <= 0:
        raise FrameError(f"the {kind} has no pixels ({width} x {height})")
    if width * height > MAX_PIXELS:
        raise FrameError(
            f"the {kind} claims {width} x {height} pixels, more than the {MAX_PIXELS} allowed"
        )
    if kind in _CHECKS:
        _CHECKS[kind](content)
    return PictureHeader(kind, width, height, white)
