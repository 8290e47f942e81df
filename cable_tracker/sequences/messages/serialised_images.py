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
_ALIGNMENT = 4


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

    def numbers(self, kinds: str) -> tuple[int, ...]:
        """Read numbers of four bytes each: `i` signed, `I` unsigned."""
        self._position += -self._position % _ALIGNMENT
        values = struct.unpack_from(self._order + kinds, self._bytes, self._position)
        self._position += _ALIGNMENT * len(kinds)
        return values

    def octets(self, length: int) -> memoryview:
        """View some bytes."""
        end = self._position + length
        if end > len(self._bytes):
            raise ValueError
        view = self._bytes[self._position : end]
        self._position = end
        return view

    def text(self, length: int) -> str:
        """Read a string of some bytes, the last of which is zero."""
        return bytes(self.octets(length)).rstrip(b"\0").decode("utf-8", errors="replace")

    def header(self) -> MessageHeader:
        """Read a std_msgs/Header."""
        sec, nanosec, length = self.numbers("iII")
        return MessageHeader(sec, nanosec, self.text(length))


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
        height, width, length = reader.numbers("III")
        encoding = reader.text(length)
        is_bigendian = bool(reader.octets(1)[0])
        step, length = reader.numbers("II")
        data = reader.octets(length)
    except (struct.error, IndexError, ValueError) as error:
        raise FrameError("the bytes received are no sensor_msgs/Image") from error
    return header, RawImage(encoding, height, width, step, is_bigendian, data)


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
        (length,) = reader.numbers("I")
        encoding = reader.text(length)
        (length,) = reader.numbers("I")
        image = CompressedImage(encoding, reader.octets(length))
    except (struct.error, IndexError, ValueError) as error:
        raise FrameError("the bytes received are no sensor_msgs/CompressedImage") from error
    return header, image
