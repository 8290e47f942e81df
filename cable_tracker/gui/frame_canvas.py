"""The canvas that shows pictures and what is drawn on them."""

from __future__ import annotations

from nicegui.element import Element

from cable_tracker.gui.frame_channel import FrameChannel


class FrameCanvas(Element, component="frame_canvas.js", esm={"cable-tracker-browser": "browser"}):
    """Shows the pictures of a channel."""

    def __init__(self, channel: FrameChannel) -> None:
        super().__init__()
        self._props["channel"] = channel.name
