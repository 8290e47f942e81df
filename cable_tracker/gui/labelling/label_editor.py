"""The part of the page in which labels are drawn."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from nicegui import ui
from nicegui.element import Element

from cable_tracker.gui.labelling.labels import FrameLabel
from cable_tracker.gui.web.frame_channel import BROWSER_MODULES, FrameChannel
from cable_tracker.printable import printable
from cable_tracker.visualisation.palette import AMBER, GREEN, RED, SKY, STRAW, Colour, css

STYLE = Path(__file__).with_name("label_editor.css")

PRIMARY = "#2a7fb8"
"""Colour of the buttons of dialogs: the blue of proposals, dark enough for white letters."""

COLOURS: Mapping[str, Colour] = {
    "hand": GREEN,
    "proposed": GREEN,
    "interpolated": STRAW,
    "no_cable": RED,
    "proposal": SKY,
    "warning": AMBER,
}
"""Colours of labels by their flags; texts and line styles say the same."""


class LabelEditor(Element, component="label_editor.js", esm=BROWSER_MODULES):
    """Picture, numbers, buttons and slider. What a browser says of it comes as events.

    ``ready {frame, request}``
        It is there, and wants a frame; the picture that answers names the request.
    ``go {frame, request}``
        It wants another one.
    ``commit {serial, frame, label, merges}``
        The label of a frame was changed; ``label`` is ``{flag, state}``, or null if it is gone.
    ``command {name, frame, everywhere}``
        Anything else, by its name.

    Parameters
    ----------
    recording : str
        Name of the recording; key under which the browser stores the current frame.
    """

    def __init__(self, channel: FrameChannel, recording: str) -> None:
        super().__init__()
        self._props["channel"] = channel.name
        ui.add_css(STYLE.read_text(encoding="utf-8"))
        ui.colors(primary=PRIMARY)
        self._props["recording"] = recording
        self._props["colours"] = {name: css(colour) for name, colour in COLOURS.items()}
        for name, colour in COLOURS.items():
            self.style(f"--{name.replace('_', '-')}: {css(colour)}")

    def load(self, news: Mapping[str, object]) -> None:
        """Show all labels anew."""
        self.run_method("load", news)

    def update_labels(self, news: Mapping[str, object]) -> None:
        """Show changed labels, and the state of the workspace."""
        self.run_method("update", news)

    def go_to(self, frame: int) -> None:
        """Lead the user to a frame."""
        self.run_method("goTo", frame)

    def propose(self, frame: int, state: list[float] | None, message: str) -> None:
        """Show a proposal, or why there is none."""
        self.run_method("proposed", {"frame": frame, "state": state, "message": message})

    def show_message(self, text: str, kind: str = "") -> None:
        """Show a message; `kind` is ``warning``, ``error`` or nothing."""
        self.run_method("say", {"text": printable(text), "kind": kind})


def label_row(frame: int, label: FrameLabel | None) -> list[object]:
    """Return a label as the browser has it: frame, flag, d, alpha, w, beta [px, rad]."""
    if label is None:
        return [frame, None, None]
    return [frame, label.flag, places(label)]


def places(label: FrameLabel) -> list[float] | None:
    """Return d, alpha, w, beta of a label [px, rad]; None if it says that there is no cable."""
    state = label.state
    if state is None:
        return None
    return [state.distance, state.angle, state.width, state.skew]
