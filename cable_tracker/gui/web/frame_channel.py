"""Pictures for browsers: packets, and the channel that sends the newest once the last is drawn.

A packet is a description in JSON and its binary sections, in one message. Image and overlay come
together, so that what is drawn on a picture is always of that picture. The browser's half is
`browser/feed.js`.
"""

from __future__ import annotations

import asyncio
import json
import secrets
import struct
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from starlette.websockets import WebSocket, WebSocketDisconnect

from cable_tracker.arrays import FloatArray

ALIGNMENT = 4
"""A Float32Array of the browser must begin at a multiple of this many bytes."""

BROWSER_MODULES = {"cable-tracker-browser": str(Path(__file__).parents[1] / "browser")}
"""The scripts that elements of pages share, by their name in the browser. NiceGUI takes a name for
one path only, so all elements say it alike."""


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


@dataclass(slots=True, eq=False)
class _Viewer:
    """One browser that looks at a channel. Its events belong to the loop that serves it."""

    loop: asyncio.AbstractEventLoop
    fresh: asyncio.Event = field(default_factory=asyncio.Event)
    drawn: asyncio.Event = field(default_factory=asyncio.Event)
    waits: bool = True


class FrameChannel:
    """Hands packets to any number of browsers, each at its own pace.

    A browser that is slow, or at the end of a slow link, misses pictures and is never behind: it
    gets the newest one when it has drawn the last. It makes no other part wait, neither the other
    browsers nor the publisher.

    Attributes
    ----------
    name : str
        Name under which browsers ask for it; it cannot be guessed.

    Parameters
    ----------
    when_wanted : callable
        Called when a browser has begun to wait for a picture, with whether it has just come; from
        the thread of the server, so it must not take long.
    """

    def __init__(self, when_wanted: Callable[[bool], None] = lambda _is_new: None) -> None:
        self._when_wanted = when_wanted
        self.name = secrets.token_urlsafe(12)
        self._lock = threading.Lock()
        self._viewers: set[_Viewer] = set()
        self._latest: bytes | None = None

    @property
    def is_wanted(self) -> bool:
        """Whether any browser could draw a picture now. If not, none need be made."""
        with self._lock:
            return any(viewer.waits for viewer in self._viewers)

    def publish(self, packet: bytes) -> None:
        """Give out a packet; from any thread. It takes the place of one that was not fetched."""
        with self._lock:
            self._latest = packet
            viewers = tuple(self._viewers)
        for viewer in viewers:
            # The loop of a server that is closing takes no more calls.
            with suppress(RuntimeError):
                viewer.loop.call_soon_threadsafe(viewer.fresh.set)

    async def serve(self, websocket: WebSocket) -> None:
        """Send packets to one browser until it goes.

        Parameters
        ----------
        websocket : WebSocket
            The connection. Every text that comes from it says that the last packet is drawn.
        """
        await websocket.accept()
        viewer = _Viewer(asyncio.get_running_loop())
        with self._lock:
            self._viewers.add(viewer)
            if self._latest is not None:
                viewer.fresh.set()
        self._when_wanted(True)
        sender = asyncio.create_task(self._send(websocket, viewer))
        try:
            while True:
                await websocket.receive_text()
                viewer.drawn.set()
        except WebSocketDisconnect:
            pass
        finally:
            with self._lock:
                self._viewers.discard(viewer)
            sender.cancel()
            with suppress(asyncio.CancelledError):
                await sender

    async def _send(self, websocket: WebSocket, viewer: _Viewer) -> None:
        with suppress(WebSocketDisconnect):
            while True:
                await viewer.fresh.wait()
                viewer.fresh.clear()
                with self._lock:
                    packet = self._latest
                    viewer.waits = False
                assert packet is not None
                viewer.drawn.clear()
                await websocket.send_bytes(packet)
                await viewer.drawn.wait()
                with self._lock:
                    viewer.waits = True
                self._when_wanted(False)
