"""Read images from messages as they come over the wire, without building message objects.

A middleware can hand out the bytes of a message. To make an object of them copies the pixels twice
more; here the pixels stay where they are. The format is CDR, version 1, as in "Common Data
Representation" of the DDS interoperability protocol (OMG, DDSI-RTPS 2.5, chapter 10).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

from cable_tracker.errors import FrameError
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.stamps import NANOSECONDS

_ENCAPSULATION = 4
_BYTE_ORDERS = {b"\x00\x00": ">", b"\x00\x01": "<"}

_HEADER = "iIs"
"""Fields of a std_msgs/Header, as `_read_fields` takes them: sec, nanosec, frame_id."""


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


def _read_fields(message: bytes, kinds: str, byte_order: str | None = None) -> list[Any]:
    """Read the first fields of a message.

    Parameters
    ----------
    message : bytes
        Serialised message.
    kinds : str
        A letter for each field: `i` and `I` for integers of 32 bits, signed and unsigned, `?` for a
        truth value, `s` for a string, and `o` for a sequence of octets, which is viewed.
    byte_order : str or None
        As of `struct`; None: that of the encapsulation.
    """
    order = byte_order or _BYTE_ORDERS.get(message[:2])
    if order is None or len(message) < _ENCAPSULATION:
        raise ValueError
    octets = memoryview(message)[_ENCAPSULATION:]
    fields: list[Any] = []
    position = 0
    for kind in kinds:
        # The number of its octets precedes a string or a sequence.
        number = struct.Struct(order + ("I" if kind in "so" else kind))
        # Numbers begin at multiples of their size.
        position += -position % number.size
        (value,) = number.unpack_from(octets, position)
        position += number.size
        if kind in "so":
            begin, position = position, position + value
            if position > len(octets):
                raise ValueError
            value = octets[begin:position]
        # A string ends with a zero.
        fields.append(bytes(value).rstrip(b"\0").decode(errors="replace") if kind == "s" else value)
    return fields


def read_header(beginning: bytes, *, is_ros1: bool = False) -> MessageHeader | None:
    """Read the header that a message begins with, whatever follows; None where none can be read.

    A ROS 1 header begins with a number in the place of the encapsulation, and is little-endian.
    """
    try:
        return MessageHeader(*_read_fields(beginning, _HEADER, "<" if is_ros1 else None))
    except (struct.error, ValueError):
        return None


def read_serialised_image(message: bytes) -> tuple[MessageHeader, RawImage]:
    """Read a sensor_msgs/Image; its pixels are a view of the message.

    Raises
    ------
    FrameError
        The bytes are no such message. Whether the fields fit together is not looked at.
    """
    try:
        *header, height, width, encoding, is_bigendian, step, data = _read_fields(
            message, f"{_HEADER}IIs?Io"
        )
    except (struct.error, ValueError) as error:
        raise FrameError("the bytes received are no sensor_msgs/Image") from error
    image = RawImage(encoding, height, width, step, is_bigendian, data)
    return MessageHeader(*header), image


def read_serialised_compressed_image(message: bytes) -> tuple[MessageHeader, CompressedImage]:
    """Read a sensor_msgs/CompressedImage; its bytes are a view of the message.

    Raises
    ------
    FrameError
        The bytes are no such message.
    """
    try:
        *header, encoding, data = _read_fields(message, f"{_HEADER}so")
    except (struct.error, ValueError) as error:
        raise FrameError("the bytes received are no sensor_msgs/CompressedImage") from error
    return MessageHeader(*header), CompressedImage(encoding, data)
