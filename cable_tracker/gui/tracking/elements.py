"""The parts of the tracking window that are drawn in the browser."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any

from nicegui.element import Element

from cable_tracker.gui.subject import Subject
from cable_tracker.gui.tracking.picture_feed import STATUSES
from cable_tracker.gui.web.frame_channel import BROWSER_MODULES, FrameChannel
from cable_tracker.visualisation import palette

COLOURS = {
    "particles": palette.css(palette.PARTICLES),
    "estimate": palette.css(palette.ESTIMATE),
    "truth": palette.css(palette.TRUTH),
    "initialising": palette.css(palette.AMBER),
}


class _ChannelElement(Element):
    """Shows a part of each packet of a channel.

    Parameters
    ----------
    channel : FrameChannel
        Where the packets come from. Only the picture fetches them; the others get them from it.
    props : mapping
        Further properties of the browser element.
    """

    def __init__(self, channel: FrameChannel, props: Mapping[str, object]) -> None:
        super().__init__()
        self._props["channel"] = channel.name
        self._props.update(props)


class _Changing(Element):
    """An element whose properties change, but are sent only where they do."""

    def show(self, **props: Any) -> None:  # noqa: ANN401
        """Change properties."""
        if any(name not in self._props or self._props[name] != props[name] for name in props):
            self._props.update(props)
            self.update()


class PlainButton(Element):
    """A button of HTML; those of the library are too large for a panel of instruments."""

    def __init__(self, text: str, action: Callable[[], Awaitable[None]], title: str) -> None:
        super().__init__("button")
        self.props(f'type=button title="{title}"')
        self.on("click", lambda _event: action())
        self._text = text

    def set_text(self, text: str) -> None:
        """Write something else on it."""
        if text != self._text:
            self._text = text
            self.update()


def _components(subject: Subject) -> dict[str, object]:
    return {"names": subject.names, "units": subject.units, "truths": subject.truths}


class TrackingPicture(
    _ChannelElement, _Changing, component="tracking_picture.js", esm=BROWSER_MODULES
):
    """The picture, and where the user draws what is followed: event `draw`.

    Parameters
    ----------
    widens : bool
        Whether the user says how wide it is where a line is drawn.
    """

    def __init__(self, channel: FrameChannel, subject: Subject, *, widens: bool) -> None:
        layers = [
            {"name": name, "title": title, "colour": palette.css(colour), "opacity": opacity}
            for name, title, colour, opacity in subject.layers
        ]
        props = {"layers": layers, "shape": subject.shape, "widens": widens, "stale": False}
        super().__init__(channel, props)


class ParticlePlots(_ChannelElement, component="particle_plots.js", esm=BROWSER_MODULES):
    """One small plot for each component of the state."""

    def __init__(self, channel: FrameChannel, subject: Subject) -> None:
        props = _components(subject) | {"spans": subject.least_spans, "colours": COLOURS}
        super().__init__(channel, props)


class NumberPanel(_ChannelElement, _Changing, component="number_panel.js", esm=BROWSER_MODULES):
    """Estimate and filter in numbers."""

    def __init__(self, channel: FrameChannel, subject: Subject) -> None:
        super().__init__(channel, _components(subject) | {"count": 0})


class HistoryPlot(_ChannelElement, component="history_plot.js", esm=BROWSER_MODULES):
    """The last half minute."""

    def __init__(self, channel: FrameChannel, subject: Subject) -> None:
        statuses = [palette.css(palette.status_colour(status)) for status in STATUSES]
        lanes = [list(lane) for lane in subject.lanes]
        super().__init__(channel, {"colours": COLOURS, "statuses": statuses, "lanes": lanes})


class TransportBar(_ChannelElement, _Changing, component="transport_bar.js", esm=BROWSER_MODULES):
    """Play, pause, step, seek and speed: event `command`."""

    def __init__(self, channel: FrameChannel, speeds: Sequence[str]) -> None:
        super().__init__(
            channel, {"playing": False, "speed": "1", "speeds": list(speeds), "count": 0}
        )


class Shortcuts(Element, component="shortcuts.js"):
    """Keys: event `command`.

    Parameters
    ----------
    keys : mapping
        Names of the actions by key, as browsers name keys.
    dialogs : sequence of str
        Names of those that open a dialog, to which the next keys belong.
    """

    def __init__(self, keys: Mapping[str, str], dialogs: Sequence[str]) -> None:
        super().__init__()
        self._props["keys"] = dict(keys)
        self._props["dialogs"] = list(dialogs)


class ParameterPanel(_Changing, component="parameter_panel.js"):
    """All parameters: events `change`, `refer`, `apply`, `load`, `save`, `understood`."""

    def __init__(self) -> None:
        super().__init__()
        self._props.update(
            groups=[],
            values={},
            references=[],
            reference="",
            referenceValues={},
            refusals={},
            fileTrouble="",
        )
