"""What a picture file says about itself, read before anything is decoded.

A picture file of a few kilobytes can ask for gigabytes of pixels, and OpenCV decodes a truncated
JPEG to a half grey picture without complaint. Both are found here from the bytes alone.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from cable_tracker.errors import FrameError

MAX_PIXELS = 64_000_000
"""Larger pictures are refused; no camera on a vehicle makes them, a damaged header does."""

_LONGEST_PNM_HEADER = 1024
_PNG_MAGIC = b"\x89PNG\r\n\x1a\n"
_PNG_CHUNK_FRAME = 12
_JPEG_MAGIC = b"\xff\xd8\xff"
_JPEG_END = b"\xff\xd9"
_JPEG_NO_LENGTH = frozenset((0x01, *range(0xD0, 0xD8)))
_JPEG_FRAME_HEADERS = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_JPEG_SCAN = 0xDA
_TIFF_WIDTH, _TIFF_HEIGHT = 256, 257
_PNM_SIZE = re.compile(rb"P[1-6](?:\s|#[^\n]*\n)+(\d{1,9})(?:\s|#[^\n]*\n)+(\d{1,9})\s")


@dataclass(frozen=True, slots=True)
class PictureHeader:
    """Kind and size of a picture file.

    Attributes
    ----------
    kind : str
        JPEG, PNG, BMP, TIFF or PNM.
    width, height : int
        Size [px].
    """

    kind: str
    width: int
    height: int


def _jpeg_segments(data: memoryview) -> Iterator[tuple[int, int]]:
    """Yield each marker and where its segment begins, up to the first scan."""
    position = 2
    marker = 0
    while marker != _JPEG_SCAN:
        if data[position] != 0xFF:
            raise ValueError
        marker = data[position + 1]
        if marker == 0xFF:
            position += 1
        elif marker in _JPEG_NO_LENGTH:
            position += 2
        else:
            yield marker, position + 2
            position += 2 + int(struct.unpack_from(">H", data, position + 2)[0])


def _jpeg_size(data: memoryview) -> tuple[int, int]:
    for marker, position in _jpeg_segments(data):
        if marker in _JPEG_FRAME_HEADERS:
            height, width = struct.unpack_from(">HH", data, position + 3)
            return width, height
    raise ValueError


def _png_size(data: memoryview) -> tuple[int, int]:
    name, width, height = struct.unpack_from(">4sII", data, 12)
    if name != b"IHDR":
        raise ValueError
    return width, height


def _bmp_size(data: memoryview) -> tuple[int, int]:
    (header_size,) = struct.unpack_from("<I", data, 14)
    width, height = struct.unpack_from("<HH" if header_size == 12 else "<ii", data, 18)
    return width, abs(height)


def _tiff_size(data: memoryview) -> tuple[int, int]:
    order = "<" if bytes(data[:2]) == b"II" else ">"
    (directory,) = struct.unpack_from(order + "I", data, 4)
    (count,) = struct.unpack_from(order + "H", data, directory)
    sizes: dict[int, int] = {}
    for entry in range(directory + 2, directory + 2 + 12 * count, 12):
        tag, kind = struct.unpack_from(order + "HH", data, entry)
        if tag in (_TIFF_WIDTH, _TIFF_HEIGHT):
            (size,) = struct.unpack_from(order + ("H" if kind == 3 else "I"), data, entry + 8)
            # Said twice: which of the two counts is for the decoder to say.
            sizes[tag] = max(size, sizes.get(tag, 0))
    return sizes[_TIFF_WIDTH], sizes[_TIFF_HEIGHT]


def _pnm_size(data: memoryview) -> tuple[int, int]:
    match = _PNM_SIZE.match(bytes(data[:_LONGEST_PNM_HEADER]))
    if match is None:
        raise ValueError
    return int(match[1]), int(match[2])


_KINDS: tuple[tuple[bytes, str, Callable[[memoryview], tuple[int, int]]], ...] = (
    (_JPEG_MAGIC, "JPEG", _jpeg_size),
    (_PNG_MAGIC, "PNG", _png_size),
    (b"BM", "BMP", _bmp_size),
    (b"II*\0", "TIFF", _tiff_size),
    (b"MM\0*", "TIFF", _tiff_size),
    *((b"P%d" % number, "PNM", _pnm_size) for number in range(1, 7)),
)


def _recognise(start: bytes) -> tuple[str, Callable[[memoryview], tuple[int, int]]]:
    for magic, kind, read_size in _KINDS:
        if start.startswith(magic):
            return kind, read_size
    raise FrameError("the data is no picture: neither JPEG nor PNG by its first bytes")


def _check_jpeg_end(data: memoryview) -> None:
    # An end mark before the scan belongs to a thumbnail, and within a scan none can occur.
    try:
        scan = max(position for _, position in _jpeg_segments(data))
    except (struct.error, IndexError, ValueError):
        scan = len(data)
    if _JPEG_END not in bytes(data[scan:]):
        raise FrameError("the JPEG is truncated: its end is missing")


def _check_png_chunks(data: memoryview) -> None:
    position = len(_PNG_MAGIC)
    name = b""
    while name != b"IEND":
        if position + _PNG_CHUNK_FRAME > len(data):
            raise FrameError("the PNG is truncated: its end is missing")
        length, name = struct.unpack_from(">I4s", data, position)
        end = position + _PNG_CHUNK_FRAME + length
        if end > len(data):
            raise FrameError("the PNG is truncated: its end is missing")
        if zlib.crc32(data[position + 4 : end - 4]) != struct.unpack_from(">I", data, end - 4)[0]:
            raise FrameError("the PNG is damaged: a checksum is wrong")
        position = end


_CHECKS: dict[str, Callable[[memoryview], None]] = {
    "JPEG": _check_jpeg_end,
    "PNG": _check_png_chunks,
}


def read_picture_header(data: memoryview) -> PictureHeader:
    """Read kind and size of a whole picture file, and check that it is all there.

    Parameters
    ----------
    data : memoryview
        All bytes of the file.

    Raises
    ------
    FrameError
        No bytes, not a picture, a damaged header, no pixels, more than `MAX_PIXELS` pixels, or a
        JPEG or PNG whose end is missing, or a PNG with a wrong checksum.
    """
    if not len(data):
        raise FrameError("the picture holds no bytes")
    kind, read_size = _recognise(bytes(data[: len(_PNG_MAGIC)]))
    try:
        width, height = read_size(data)
    except (struct.error, IndexError, KeyError, ValueError) as error:
        raise FrameError(f"the header of the {kind} is damaged") from error
    if width <= 0 or height <= 0:
        raise FrameError(f"the {kind} has no pixels ({width} x {height})")
    if width * height > MAX_PIXELS:
        raise FrameError(
            f"the {kind} claims {width} x {height} pixels, more than the {MAX_PIXELS} allowed"
        )
    if kind in _CHECKS:
        _CHECKS[kind](data)
    return PictureHeader(kind, width, height)
