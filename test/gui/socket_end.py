"""The browser's end of a WebSocket."""

import asyncio

from starlette.websockets import WebSocketDisconnect


class Browser:
    """A WebSocket whose other end is the test."""

    def __init__(self):
        self.received = asyncio.Queue()
        self._texts = asyncio.Queue()
        self.accepted = False

    async def accept(self):
        self.accepted = True

    async def receive_text(self):
        text = await self._texts.get()
        if text is None:
            raise WebSocketDisconnect
        return text

    async def send_bytes(self, data):
        await self.received.put(data)

    def has_drawn(self):
        self._texts.put_nowait("1")

    def leaves(self):
        self._texts.put_nowait(None)
