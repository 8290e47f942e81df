"""The window in which a recording is labelled."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from nicegui import background_tasks, core, ui
from nicegui.events import GenericEventArguments

from cable_tracker.errors import CableTrackerError, ParameterError, RecordingError
from cable_tracker.gui.labelling.document import Changes
from cable_tracker.gui.labelling.label_editor import LabelEditor, label_row, places
from cable_tracker.gui.labelling.label_file import OverwriteError
from cable_tracker.gui.labelling.labels import FrameLabel, Origin, flagged_label, state_from_page
from cable_tracker.gui.labelling.pictures import Picture
from cable_tracker.gui.labelling.proposals import LabelProposal
from cable_tracker.gui.labelling.workspace import Workspace
from cable_tracker.gui.web.frame_channel import FrameChannel, jpeg_section, pack
from cable_tracker.gui.web.server import Channels, Listening, serve, typed_path
from cable_tracker.printable import printable
from cable_tracker.sequences.tables.estimates import format_stamp

AUTOSAVE_DELAY = 1.0
"""Longest time between an edit and the autosave [s]."""

T = TypeVar("T")


@dataclass(eq=False)
class LabelServer:
    """State shared by all browsers.

    Attributes
    ----------
    workspace : Workspace
        The recording and its labels.
    channels : Channels
        Channels that send pictures to browsers.
    reader, proposer : Executor
        Threads that read frames, and that propose labels.
    """

    workspace: Workspace
    channels: Channels = field(default_factory=Channels)
    reader: Executor = field(default_factory=lambda: ThreadPoolExecutor(1, "frames"))
    proposer: Executor = field(default_factory=lambda: ThreadPoolExecutor(1, "proposals"))
    _timer: asyncio.TimerHandle | None = None

    def run(self, listening: Listening, started: Callable[[], None]) -> None:
        """Serve the window until a signal ends it."""
        stop_listening = self.workspace.listen(self._schedule_autosave)
        try:
            serve(
                lambda: LabelPage(self).build(),
                self.channels,
                listening,
                f"{printable(self.workspace.source.path.name)} - labels",
                started=started,
                stopped=self.workspace.stopped.set,
            )
        finally:
            stop_listening()
            self.workspace.stopped.set()
            for executor in (self.reader, self.proposer):
                executor.shutdown(wait=False, cancel_futures=True)
            self.workspace.autosave()

    def _schedule_autosave(self, _changes: Changes | None) -> None:
        if self._timer is None and core.loop is not None:
            self._timer = core.loop.call_later(AUTOSAVE_DELAY, self._autosave)

    def _autosave(self) -> None:
        self._timer = None
        self.workspace.autosave()


@dataclass(frozen=True, slots=True)
class _Request:
    """What a browser wants to see.

    Attributes
    ----------
    frame : int
        Number of the frame, which the recording has as far as is known.
    number : int
        Number of the request, by which the browser knows the answer.
    """

    frame: int
    number: int


class LabelPage:
    """One browser's page: its own place in the recording, and the labels that all share.

    Parameters
    ----------
    server : LabelServer
        State shared by all windows of the server.
    """

    def __init__(self, server: LabelServer) -> None:
        self._server = server
        self._workspace = server.workspace
        self._channel = server.channels.add(FrameChannel())
        self._number = 0
        self._wanted: _Request | None = None
        self._frame = 0
        self._is_loading = False
        self._serial = 0
        self._asked: int | None = None
        self._resume_dialog: ui.dialog | None = None

    def build(self) -> None:
        """Build the page, and end what belongs to it when the browser is gone."""
        client = ui.context.client
        self._editor = LabelEditor(self._channel, printable(self._workspace.source.path.resolve()))
        self._editor.on("ready", self._ready)
        self._editor.on("go", self._want)
        self._editor.on("commit", self._commit)
        self._editor.on("command", self._command)
        stop_listening = self._workspace.listen(self._changed)

        def close() -> None:
            stop_listening()
            self._server.channels.remove(self._channel)

        client.on_delete(close)

    # What the browser wants to see

    def _ready(self, event: GenericEventArguments) -> None:
        self._load()
        self._want(event)
        self._offer_autosaved()

    def _want(self, event: GenericEventArguments) -> None:
        frame, count = int(event.args["frame"]), self._workspace.count
        frame = max(0, frame if count is None else min(frame, count - 1))
        self._wanted = _Request(frame, int(event.args["request"]))
        if not self._is_loading:
            self._is_loading = True
            background_tasks.create(self._load_pictures())

    async def _load_pictures(self) -> None:
        """Show the frame that is wanted last; read the one behind it while none is wanted."""
        try:
            while self._wanted is not None:
                request, self._wanted = self._wanted, None
                frame = request.frame
                picture = await self._picture(frame)
                if picture is not None:
                    step = 1 if frame >= self._frame else -1
                    self._frame = frame
                    self._publish(picture, request)
                    if self._wanted is None:
                        await self._picture(frame + step, quietly=True)
        finally:
            self._is_loading = False

    async def _picture(self, frame: int, quietly: bool = False) -> Picture | None:
        if frame < 0:
            return None
        try:
            return await self._read(self._server.reader, self._workspace.picture, frame)
        except (IndexError, RecordingError) as error:
            if not quietly:
                self._editor.show_message(str(error), "error")
                self._lead_back_from(frame)
            return None

    def _lead_back_from(self, frame: int) -> None:
        """Lead to a frame that can be shown: the last one, or the one that is shown."""
        count = self._workspace.count
        is_behind = count is not None and 0 < count <= frame
        there = count - 1 if count is not None and is_behind else self._frame
        if there != frame:
            self._editor.go_to(there)

    def _publish(self, picture: Picture, request: _Request) -> None:
        self._number += 1
        description = {
            "number": self._number,
            "request": request.number,
            "size": picture.size,
            "frame": picture.frame,
            "stamp": format_stamp(picture.stamp),
            "trouble": picture.trouble and f"frame {picture.frame}: {picture.trouble}",
            "note": self._note_on(picture),
        }
        self._channel.publish(pack(description, [jpeg_section(picture.jpeg)]))

    def _note_on(self, picture: Picture) -> str:
        labels = self._workspace.document.labels
        if picture.frame not in labels or not self._workspace.is_displaced(picture):
            return ""
        return (
            f"frame {picture.frame} had another time when it was labelled; do these labels belong"
            " to this recording?"
        )

    # How things stand

    def _status(self) -> dict[str, object]:
        workspace = self._workspace
        return {
            "serial": self._serial,
            "count": workspace.count,
            "path": printable(workspace.path.absolute()),
            "name": printable(workspace.path.name),
            "changed": workspace.is_changed,
            "can_undo": workspace.document.can_undo,
            "can_redo": workspace.document.can_redo,
        }

    def _load(self) -> None:
        rows = [label_row(*item) for item in self._workspace.document.labels.items()]
        self._editor.load({"labels": rows, **self._status()})

    def _changed(self, changes: Changes | None) -> None:
        if changes is None:
            self._load()
            self._offer_autosaved()
            return
        rows = [label_row(*item) for item in changes.items()]
        self._editor.update_labels({"labels": rows, **self._status()})
        if self._workspace.trouble:
            self._editor.show_message(self._workspace.trouble, "error")

    # Edits

    def _commit(self, event: GenericEventArguments) -> None:
        self._serial = int(event.args["serial"])
        frame = int(event.args["frame"])
        document = self._workspace.document
        try:
            self._workspace.need_frame(frame)
            label = _label_of(event.args["label"])
        except (CableTrackerError, ValueError) as error:
            self._editor.show_message(str(error), "error")
            self._workspace.notify({frame: document.labels.get(frame)})
            return
        merges = bool(event.args["merges"])
        self._workspace.change(frame, label, merges=merges)

    async def _command(self, event: GenericEventArguments) -> None:
        frame = int(event.args["frame"])
        everywhere = bool(event.args["everywhere"])
        actions: Mapping[str, Callable[[], Awaitable[None]]] = {
            "undo": self._undo,
            "redo": self._redo,
            "interpolate": lambda: self._interpolate(frame, everywhere),
            "propose": lambda: self._propose(frame),
            "save": self._save,
            "save_as": self._save_as,
            "open": self._open,
        }
        action = actions.get(event.args["name"])
        if action is None:
            return
        try:
            await action()
        except CableTrackerError as error:
            self._editor.show_message(
                str(error), "warning" if isinstance(error, ParameterError) else "error"
            )

    async def _undo(self) -> None:
        self._after_step(self._workspace.undo(), "nothing to undo")

    async def _redo(self) -> None:
        self._after_step(self._workspace.redo(), "nothing to redo")

    def _after_step(self, step: tuple[int, Changes] | None, otherwise: str) -> None:
        if step is None:
            self._editor.show_message(otherwise)
            return
        frame, _ = step
        self._editor.go_to(frame)

    async def _interpolate(self, frame: int, everywhere: bool) -> None:
        document = self._workspace.document
        wanted = document.gaps_to_fill(None if everywhere else frame)
        frames = [number for gap in wanted for number in range(gap.before, gap.after + 1)]
        damage = await self._read_times(frames)
        # Another browser may have edited in the meantime.
        still = [gap for gap in document.gaps_to_fill(None) if gap in wanted]
        self._workspace.interpolate(frame, still)
        count = sum(len(gap.frames) for gap in still)
        self._show_done(f"interpolated {count} frame{'s' if count != 1 else ''}", damage)

    async def _read_times(self, frames: Iterable[int]) -> RecordingError | None:
        """Learn the times of frames that are not known yet; returns the damage that was met."""
        missing = self._workspace.missing_stamps(frames)
        return await self._read(self._server.reader, self._workspace.read_stamps, missing)

    def _show_done(self, message: str, damage: RecordingError | None) -> None:
        if damage is None:
            self._editor.show_message(message)
        else:
            self._editor.show_message(f"{message}; {damage}", "error")

    async def _propose(self, frame: int) -> None:
        self._asked = frame
        labels = dict(self._workspace.document.labels)
        try:
            found = await self._read(
                self._server.proposer,
                self._workspace.propose,
                frame,
                labels,
                lambda: self._asked == frame,
            )
        except (IndexError, RecordingError) as error:
            # The browser waits for an answer.
            found = LabelProposal(frame, None, str(error))
        if self._asked == frame:
            self._editor.propose(frame, places(FrameLabel(found.state)), found.message)

    # Files

    async def _save(self) -> None:
        await self._save_with(self._workspace.save)

    async def _save_as(self) -> None:
        given = await self._ask_path("Save the labels as", "Save", self._workspace.path)
        if given is not None:
            await self._save_with(
                lambda overwrite: self._workspace.save_as(given, overwrite=overwrite)
            )

    async def _save_with(self, save: Callable[..., None]) -> None:
        damage = await self._read_times(self._workspace.document.labels)
        try:
            save(overwrite=False)
        except OverwriteError as error:
            if not await self._confirm(str(error), "Overwrite"):
                self._editor.show_message("nothing was saved", "warning")
                return
            save(overwrite=True)
        self._show_done(f"saved {self._workspace.path}", damage)

    async def _open(self) -> None:
        given = await self._ask_path("Open a label file", "Open", self._workspace.path)
        if given is None:
            return
        question = "There are labels that are not saved. They stay in the autosave file."
        if self._workspace.is_changed and not await self._confirm(question, "Open all the same"):
            return
        self._workspace.open(given)
        self._editor.show_message(f"opened {given}")

    async def _ask_path(self, title: str, action: str, path: Path) -> Path | None:
        with ui.dialog() as dialog, ui.card().classes("w-[560px] max-w-full"):
            ui.label(title).classes("text-lg")
            field = ui.input(
                "file on the machine that runs cable-tracker", value=printable(path.absolute())
            )
            field.props("autofocus outlined dense").classes("w-full")
            field.on("keydown.enter", lambda: dialog.submit(field.value))
            with ui.row().classes("w-full justify-end"):
                ui.button("Cancel", on_click=lambda: dialog.submit(None)).props("flat")
                ui.button(action, on_click=lambda: dialog.submit(field.value))
        given = await dialog
        dialog.delete()
        return typed_path(given) if given else None

    async def _confirm(self, question: str, action: str) -> bool:
        with ui.dialog() as dialog, ui.card().classes("w-[520px] max-w-full"):
            ui.label(printable(question)).classes("break-words")
            with ui.row().classes("w-full justify-end"):
                ui.button("Cancel", on_click=lambda: dialog.submit(False)).props("flat autofocus")
                ui.button(action, on_click=lambda: dialog.submit(True)).props("color=negative")
        answer = bool(await dialog)
        dialog.delete()
        return answer

    def _offer_autosaved(self) -> None:
        """Ask what is to become of unsaved labels; when one browser has said it, no other asks."""
        if self._resume_dialog is not None:
            self._resume_dialog.delete()
            self._resume_dialog = None
        if self._workspace.autosaved is None:
            return
        with (
            self._editor.client.content,
            ui.dialog().props("persistent") as dialog,
            ui.card().classes("w-[520px] max-w-full"),
        ):
            ui.label("Labels that were not saved").classes("text-lg")
            ui.label(printable(self._workspace.describe_autosaved())).classes("break-words")
            with ui.row().classes("w-full justify-end"):
                ui.button("Discard them", on_click=self._workspace.discard).props("flat")
                ui.button("Resume", on_click=self._workspace.resume).props("autofocus")
        self._resume_dialog = dialog
        dialog.open()

    async def _read(self, executor: Executor, function: Callable[..., T], *arguments: object) -> T:
        """Call a function that reads frames in another thread, and notify all if the end is met."""
        loop = asyncio.get_running_loop()
        before = self._workspace.count
        try:
            return await loop.run_in_executor(executor, function, *arguments)
        finally:
            if self._workspace.count != before:
                self._workspace.notify({})


def _label_of(said: Mapping[str, object] | None) -> FrameLabel | None:
    """Return the label that a browser has sent; see `LabelEditor`."""
    if said is None:
        return None
    flag, values = str(said["flag"]), said["state"]
    if flag == Origin.INTERPOLATED.value:
        raise ParameterError("only the server interpolates")
    return flagged_label(state_from_page(values) if isinstance(values, list) else None, flag)
