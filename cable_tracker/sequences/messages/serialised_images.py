"""Read images from messages as they come over the wire, without building message objects.

A middleware can hand out the bytes of a message. To make an object of them copies the pixels twice
more; here the pixels stay where they are. The format is CDR, version 1, as in "Common Data
Representation" of the DDS interoperability protocol (OMG, DDSI-RTPS 2.5, chapter 10).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from cable_tracker.errors import FrameError
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.stamps import NANOSECONDS

_ENCAPSULATION = 4
_BYTE_ORDERS = {b"\x00\x00": ">", b"\x00\x01": "<"}
_NUMBER = 4
"""Octets of a number; numbers begin at multiples of it."""


@dataclass(frozen=True, slots=True)
class MessageHeader:
    """Content of a std_msgs/Header.

    Attributes
    ----------
    sec, nanosec : int
        Time, as it was sent; its nanoseconds may be a second or more.
    frame_id : str
        Name of the coordinate frame.
    """

    sec: int
    nanosec: int
    frame_id: str

    @property
    def stamp(self) -> int:
        """Time [ns]; 0 where none is given."""
        return self.sec * NANOSECONDS + self.nanosec


class _Reader:
    """Reads the fields of a message one after the other."""

    def __init__(self, message: bytes, order: str | None = None) -> None:
        order = order or _BYTE_ORDERS.get(message[:2])
        if order is None or len(message) < _ENCAPSULATION:
            raise ValueError
        self._order = order
        self._bytes = memoryview(message)[_ENCAPSULATION:]
        self._position = 0

    def flag(self) -> bool:
        """Read a truth value of one octet."""
        self._position += 1
        return bool(self._bytes[self._position - 1])

    def fields(self, kinds: str = "") -> tuple[list[int], memoryview]:
        """Read numbers, `i` signed and `I` unsigned, and view the string or sequence after them."""
        begin = self._position + -self._position % _NUMBER
        # The number of its octets precedes a sequence.
        *numbers, length = struct.unpack_from(f"{self._order}{kinds}I", self._bytes, begin)
        begin += _NUMBER * (len(kinds) + 1)
        self._position = begin + length
        if self._position > len(self._bytes):
            raise ValueError
        return numbers, self._bytes[begin : self._position]

    def header(self) -> MessageHeader:
        """Read a std_msgs/Header."""
        (sec, nanosec), frame_id = self.fields("iI")
        return MessageHeader(sec, nanosec, _text(frame_id))


def _text(octets: memoryview) -> str:
    """Return the text of a string, which ends with a zero."""
    return bytes(octets).rstrip(b"\0").decode("utf-8", errors="replace")


def read_header(beginning: bytes, *, is_ros1: bool = False) -> MessageHeader | None:
    """Read the header that a message begins with, whatever follows; None where none can be read.

    A ROS 1 header begins with a number in the place of the encapsulation, and is little-endian.
    """
    try:
        return _Reader(beginning, "<" if is_ros1 else None).header()
    except (struct.error, IndexError, ValueError):
        return None


def read_serialised_image(message: bytes) -> tuple[MessageHeader, RawImage]:
    """Read a sensor_msgs/Image; its pixels are a view of the message.

    Raises
    ------
    FrameError
        The bytes are no such message. Whether the fields fit together is not looked at.
    """
    try:
        reader = _Reader(message)
        header = reader.header()
        (height, width), encoding = reader.fields("II")
        is_bigendian = reader.flag()
        (step,), data = reader.fields("I")
    except (struct.error, IndexError, ValueError) as error:
        raise FrameError("the bytes received are no sensor_msgs/Image") from error
    return header, RawImage(_text(encoding), height, width, step, is_bigendian, data)


def read_serialised_compressed_image(message: bytes) -> tuple[MessageHeader, CompressedImage]:
    """Read a sensor_msgs/CompressedImage; its bytes are a view of the message.

    Raises
    ------
    FrameError
        The bytes are no such message.
    """
    try:
        reader = _Reader(message)
        header = reader.header()
        _, encoding = reader.fields()
        _, data = reader.fields()
    except (struct.error, IndexError, ValueError) as error:
        raise FrameError("the bytes received are no sensor_msgs/CompressedImage") from error
    return header, CompressedImage(_text(encoding), data)
