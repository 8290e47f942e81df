"""The page on which a filter is watched and tuned."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from nicegui import run, ui
from nicegui.events import GenericEventArguments

from cable_tracker.cable.model.state import CableState
from cable_tracker.errors import CableTrackerError, GuiError
from cable_tracker.gui.session.recording_session import RecordingRequest
from cable_tracker.gui.session.session import Session
from cable_tracker.gui.subject import TARGET
from cable_tracker.gui.tracking.commands import (
    DIALOGS,
    POINTER_HELP,
    SPEEDS,
    command_player,
    commands_for,
    speed_label,
)
from cable_tracker.gui.tracking.dialogs import (
    CABLE_FIELDS,
    CABLE_START,
    LIVE_CABLE_FIELDS,
    TARGET_FIELDS,
    TARGET_START,
    FormDialog,
    HelpDialog,
    NumberDialog,
    OpenDialog,
    SaveDialog,
)
from cable_tracker.gui.tracking.elements import (
    HistoryPlot,
    NumberPanel,
    ParameterPanel,
    ParticlePlots,
    PlainButton,
    Shortcuts,
    TrackingPicture,
    TransportBar,
)
from cable_tracker.gui.tracking.parameter_sheet import (
    groups_for_page,
    parameter_text,
    value_from_field,
    values_for_page,
    values_from_text,
)
from cable_tracker.gui.tracking.shared_session import (
    SharedSession,
    drawn_state,
    start_at,
    start_with_box,
)
from cable_tracker.gui.web.server import Channels, Listening, serve
from cable_tracker.tracking.parameter_table import ParameterValue

REFRESH = 0.2
"""Interval between two checks whether another page has played, paused or opened something [s]."""

REFRESH_OF_PARAMETERS = 1.0
"""Interval between two checks whether another page has changed a parameter [s]."""

STYLE = Path(__file__).with_name("window.css").read_text(encoding="utf-8")


def serve_tracking_window(
    shared: SharedSession,
    listening: Listening,
    *,
    started: Callable[[], None],
) -> None:
    """Serve the page until a signal ends it, and close the session then.

    Parameters
    ----------
    shared : SharedSession
        Session and recording that the page shows.
    listening : Listening
        Address to listen on.
    started : callable
        Called when the server has begun to listen.
    """
    channels = Channels()
    channels.add(shared.feed.channel)
    try:
        serve(
            lambda: TrackingPage(shared).build(),
            channels,
            listening,
            "cable tracker",
            started=started,
        )
    finally:
        shared.close()


class TrackingPage:
    """The page of one browser.

    Parameters
    ----------
    shared : SharedSession
        Session and recording that all windows share.
    """

    def __init__(self, shared: SharedSession) -> None:
        self._shared = shared
        self._version = shared.version
        self._values: Mapping[str, ParameterValue] = {}
        self._refusals: dict[str, str] = {}
        self._reference = next(iter(shared.references))
        self._picture: TrackingPicture | None = None
        self._transport: TransportBar | None = None
        self._numbers: NumberPanel | None = None
        self._parameters: ParameterPanel | None = None

    def build(self) -> None:
        """Put everything on the page."""
        ui.add_css(STYLE)
        shared = self._shared
        is_live = shared.session is not None and shared.player is None
        commands = commands_for(is_player=not is_live, noun=shared.subject.noun)
        is_target = shared.subject is TARGET
        self._open_dialog = OpenDialog(
            lambda: shared.request, self._open, TARGET_START if is_target else CABLE_START
        )
        self._save_dialog = SaveDialog(self._text_to_save, shared.subject)
        self._start_dialog = (
            NumberDialog(
                "Start where the target is", TARGET_FIELDS, self._start_with, shared.present_box
            )
            if is_target
            else NumberDialog(
                "Start where the cable is",
                LIVE_CABLE_FIELDS if is_live else CABLE_FIELDS,
                self._start_at,
                self._present_cable,
            )
        )
        shape = "live line" if is_live and not is_target else shared.subject.shape
        self._help_dialog = HelpDialog(commands, POINTER_HELP[shape])
        self._build_head(is_live)
        self._panels = ui.element("main").classes("ct-desk" + (" ct-live" if is_live else ""))
        with self._panels:
            if shared.session is not None:
                self._build_panels(shared.session)
            else:
                ui.label("No recording is open: press Open.").classes("ct-empty")
        keys = {key: command.name for command in commands for key in command.keys}
        Shortcuts(keys, DIALOGS).on("command", self._command)
        ui.timer(REFRESH, self._refresh)
        ui.timer(REFRESH_OF_PARAMETERS, self._refresh_parameters)

    def _build_head(self, is_live: bool) -> None:
        session = self._shared.session
        with ui.element("header").classes("ct-head"):
            name = session.name if session is not None else "cable tracker"
            ui.label(name if is_live else Path(name).name).classes("text-weight-bold").props(
                'role="heading" aria-level="1" data-test="title"'
            ).tooltip(name)
            if self._shared.player is not None and self._shared.player.notes:
                notes = "; ".join(self._shared.player.notes)
                ui.label(notes).classes("ct-notes").props("data-test=notes").tooltip(notes)
            self._trouble = ui.label().classes("ct-trouble")
            self._trouble.props('role="status" data-test="trouble"')
            if session is not None:
                hint = f"Type where the {self._shared.subject.noun} is (i)"
                PlainButton("start at …", lambda: self._do("start"), hint)
                PlainButton("reset", lambda: self._do("reset"), "Forget everything (r)")
                self._enable = PlainButton("", lambda: self._do("enable"), "Tracker off or on (e)")
            if not is_live:
                PlainButton("open …", lambda: self._do("open"), "Open a recording (o)")
            PlainButton("keys ?", lambda: self._do("help"), "Show the keys (?)")

    def _build_panels(self, session: Session) -> None:
        channel, subject = self._shared.feed.channel, self._shared.subject
        # The topic that tells a live node where the cable is says nothing of its width.
        widens = subject is not TARGET and self._shared.player is not None
        self._picture = TrackingPicture(channel, subject, widens=widens)
        self._picture.on("draw", self._draw)
        if self._shared.player is not None:
            self._transport = TransportBar(channel, list(SPEEDS))
            self._transport.on("command", self._command)
        HistoryPlot(channel, subject)
        self._numbers = NumberPanel(channel, subject)
        ParticlePlots(channel, subject)
        self._parameters = ParameterPanel()
        self._parameters.show(groups=groups_for_page(session.table, subject.groups))
        for event, handler in (
            ("change", self._change),
            ("refer", self._refer),
            ("apply", self._apply),
            ("load", self._load),
            ("save", self._save_dialog.open),
            ("understood", lambda: self._show_parameters(fileTrouble="")),
        ):
            self._parameters.on(event, handler)

    # What others do

    def _refresh(self) -> None:
        shared = self._shared
        if shared.version != self._version:
            ui.navigate.reload()
            return
        if shared.session is None:
            return
        trouble = shared.session.trouble
        self._trouble.set_text(trouble)
        # A node that is gone leaves its last word standing: it must not look like news.
        is_stale = bool(trouble) and shared.player is None
        if is_stale:
            self._panels.classes("ct-stale")
        else:
            self._panels.classes(remove="ct-stale")
        if self._picture is not None:
            self._picture.show(stale=is_stale)
        self._enable.set_text("switch off" if shared.session.is_enabled else "switch on")
        if shared.player is not None and self._transport is not None and self._numbers is not None:
            count = shared.player.frame_count or 0
            self._transport.show(
                playing=shared.player.is_playing,
                speed=speed_label(shared.player.speed),
                count=count,
            )
            self._numbers.show(count=count)

    async def _refresh_parameters(self) -> None:
        session = self._shared.session
        if session is None:
            return
        try:
            values = await run.io_bound(session.parameters)
        except CableTrackerError:
            # The session itself says what is wrong with it, beside the title.
            return
        # The server is about to end.
        if values is not None:
            self._values = values
            self._show_parameters()

    def _show_parameters(self, **props: Any) -> None:  # noqa: ANN401
        if self._parameters is None:
            return
        references = self._shared.references
        self._parameters.show(
            values=values_for_page(self._values),
            references=list(references),
            reference=self._reference,
            referenceValues=values_for_page(references[self._reference]),
            refusals=dict(self._refusals),
            **props,
        )

    # What the user does

    async def _command(self, event: GenericEventArguments) -> None:
        await self._do(str(event.args.get("name")), event.args.get("value"))

    async def _do(self, name: str, value: object = None) -> None:
        shared = self._shared
        dialogs: Mapping[str, FormDialog | HelpDialog] = {
            "open": self._open_dialog,
            "save": self._save_dialog,
            "start": self._start_dialog,
            "help": self._help_dialog,
        }
        if name in dialogs:
            dialogs[name].open()
        elif name == "reset" and shared.session is not None:
            await self._try(shared.session.reset)
        elif name == "enable" and shared.session is not None:
            await self._try(shared.session.enable, not shared.session.is_enabled)
        elif shared.player is not None:
            command_player(shared.player, name, value)
        self._refresh()

    async def _try(self, function: Callable[..., object], *arguments: object) -> bool:
        """Run something that may take a while; what is refused is said."""
        try:
            await run.io_bound(function, *arguments)
        except CableTrackerError as error:
            ui.notify(str(error), type="negative", multi_line=True)
            return False
        return True

    async def _draw(self, event: GenericEventArguments) -> None:
        drawn, session = event.args, self._shared.session
        ends = tuple(drawn["start"]), tuple(drawn["end"])
        if session is None:
            return
        if self._shared.subject is TARGET:
            is_done = await self._try(start_with_box, session, *ends)
        else:
            state = drawn_state(*ends, drawn["width"], tuple(drawn["size"]))
            is_done = await self._try(start_at, session, state)
        if not is_done and self._picture is not None:
            self._picture.run_method("cancel")

    def _present_cable(self) -> Sequence[float] | None:
        """Return d, alpha, w, beta of the newest estimate [px, deg]; None without a claim."""
        state = self._shared.present_state()
        if state is None or not state.is_finite():
            return None
        return state.distance, math.degrees(state.angle), state.width, math.degrees(state.skew)

    async def _start_at(self, numbers: Sequence[float]) -> None:
        """Start from d, alpha, w, beta [px, deg], or from the first two of a live node."""
        rest = [value for _, value in CABLE_FIELDS[len(numbers) :]]
        d, alpha, w, beta = (*numbers, *rest)
        state = CableState(d, math.radians(alpha), w, math.radians(beta))
        await run.io_bound(start_at, self._shared.need_session(), state)

    async def _start_with(self, sides: Sequence[float]) -> None:
        """Start with a box: left, top, right, bottom [px]."""
        left, top, right, bottom = sides
        session = self._shared.need_session()
        await run.io_bound(start_with_box, session, (left, top), (right, bottom))

    async def _open(self, request: RecordingRequest) -> None:
        await run.io_bound(self._shared.open, request)
        self._refresh()

    async def _change(self, event: GenericEventArguments) -> None:
        name, given = str(event.args["name"]), event.args["value"]
        session = self._shared.need_session()
        spec = next(spec for spec in session.table if spec.name == name)
        self._refusals.clear()
        try:
            await run.io_bound(session.change, {name: value_from_field(spec, given)})
        except CableTrackerError as error:
            self._refusals[name] = str(error)
        await self._refresh_parameters()

    def _refer(self, event: GenericEventArguments) -> None:
        name = str(event.args["name"])
        if name in self._shared.references:
            self._reference = name
        self._show_parameters()

    async def _apply(self) -> None:
        session = self._shared.need_session()
        known = {spec.name for spec in session.table}
        values = self._shared.references[self._reference]
        self._refusals.clear()
        trouble = ""
        try:
            await run.io_bound(
                session.change, {name: values[name] for name in values.keys() & known}
            )
        except CableTrackerError as error:
            trouble = f"{self._reference}: {error}"
        await self._refresh_parameters()
        self._show_parameters(fileTrouble=trouble)

    async def _load(self, event: GenericEventArguments) -> None:
        name, text = Path(str(event.args["name"])).name, event.args["text"]
        try:
            values = values_from_text(text, name, self._shared.subject)
        except CableTrackerError as error:
            self._show_parameters(fileTrouble=f"{error} Nothing has changed.")
            return
        self._shared.references[name] = values
        self._reference = name
        await self._apply()

    async def _text_to_save(self) -> str:
        """Return the file with the values in force now, which may not be those that are shown."""
        session = self._shared.need_session()
        values = await run.io_bound(session.parameters)
        if not values:
            raise GuiError(f"{session.name} has told no parameters; try again")
        return parameter_text(values, session.name, self._shared.subject)
