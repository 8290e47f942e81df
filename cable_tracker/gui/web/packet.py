"""One picture for the browser: a description in JSON and its binary sections, in one message.

Image and overlay come together, so that what is drawn on a picture is always of that picture. The
browser's half is `browser/packet.js`.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cable_tracker.arrays import FloatArray

ALIGNMENT = 4
"""A Float32Array of the browser must begin at a multiple of this many bytes."""


@dataclass(frozen=True, slots=True)
class Section:
    """Bytes of a packet that are no JSON.

    Attributes
    ----------
    name : str
        Key of the section in the packet.
    kind : str
        ``jpeg`` or ``float32``.
    shape : tuple of int
        Rows and columns of ``float32``; empty for ``jpeg``.
    data : bytes or memoryview
        The bytes, little-endian.
    """

    name: str
    kind: str
    shape: tuple[int, ...]
    data: bytes | memoryview


def jpeg_section(data: bytes | memoryview) -> Section:
    """Return the section of a JPEG file, named `picture`."""
    return Section("picture", "jpeg", (), data)


def float_section(name: str, values: FloatArray) -> Section:
    """Return the section of an array of any shape, sent as float32."""
    return Section(name, "float32", values.shape, values.astype("<f4").tobytes())


def pack(description: Mapping[str, object], sections: Sequence[Section]) -> bytes:
    """Put a description and sections into one message.

    Parameters
    ----------
    description : mapping
        Anything that JSON can say, without NaN; the key `sections` is taken.
    sections : sequence of Section
        Binary sections that follow the header.

    Returns
    -------
    bytes
        Length of the JSON (uint32, little-endian), the JSON padded with blanks, the sections, each
        at a multiple of four bytes.

    Raises
    ------
    ValueError
        A number is not finite.
    """
    directory, blocks, offset = [], [], 0
    for section in sections:
        size = len(section.data)
        directory.append(
            {
                "name": section.name,
                "kind": section.kind,
                "shape": section.shape,
                "offset": offset,
                "size": size,
            }
        )
        padding = -size % ALIGNMENT
        blocks += [bytes(section.data), bytes(padding)]
        offset += size + padding
    text = json.dumps(
        {**description, "sections": directory}, allow_nan=False, separators=(",", ":")
    ).encode()
    text += b" " * (-len(text) % ALIGNMENT)
    return b"".join((struct.pack("<I", len(text)), text, *blocks))
