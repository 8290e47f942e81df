"""The dialogs of the tracking window."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import replace
from pathlib import Path

from nicegui import run, ui

from cable_tracker.errors import CableTrackerError, GuiError
from cable_tracker.gui.session.recording_session import RecordingRequest
from cable_tracker.gui.subject import Subject
from cable_tracker.gui.tracking.commands import KeyBinding
from cable_tracker.gui.tracking.parameter_sheet import ExistingFileError, write_parameter_file
from cable_tracker.gui.web.server import typed_path
from cable_tracker.printable import printable

CABLE_START = "start: random, truth, a detector, or d,alpha,w,beta (px, rad)"
TARGET_START = "start: wait, detect, or x0,y0,x1,y1 (px from the top left)"
"""Words on the field that says where to start."""

CABLE_FIELDS = (
    ("d px, right of the centre", 0.0),
    ("alpha deg, from vertical, counter-clockwise", 0.0),
    ("w px", 40.0),
    ("beta deg", 0.0),
)
LIVE_CABLE_FIELDS = CABLE_FIELDS[:2]
TARGET_FIELDS = tuple((f"{side} px", 0.0) for side in ("left", "top", "right", "bottom"))
"""Numbers that say where to start, each with its value to begin with."""


class FormDialog(ABC):
    """A dialog with fields, a button that does something with them, and a place for refusals."""

    def __init__(self, title: str, action: str) -> None:
        self.dialog = ui.dialog().props(f'aria-label="{title}"')
        with self.dialog, ui.card().classes("w-96"):
            ui.label(title).classes("text-lg")
            self.build()
            self._refusal = ui.label().classes("text-orange-4").props('role="alert"')
            self._refusal.mark("dialog-refusal").props("data-test=dialog-refusal")
            with ui.row().classes("w-full justify-end"):
                self.build_buttons()
                ui.button("cancel", on_click=self.dialog.close).props("flat")
                ui.button(action, on_click=self.submit).props("data-test=dialog-ok")

    @abstractmethod
    def build(self) -> None:
        """Put the fields into it."""

    def build_buttons(self) -> None:
        """Put further buttons beside the usual ones."""
        return

    def open(self) -> None:
        """Show it, with nothing refused."""
        self.refuse("")
        self.dialog.open()

    def refuse(self, message: str) -> None:
        """Show why the action failed."""
        self._refusal.set_text(printable(message))

    async def submit(self) -> None:
        """Run the dialog's action, and close the dialog if it succeeded."""
        await self._attempt(self.do)

    async def _attempt(self, action: Callable[[], Awaitable[None]]) -> None:
        try:
            await action()
        except CableTrackerError as error:
            self.refuse(str(error))
            return
        self.dialog.close()

    @abstractmethod
    async def do(self) -> None:
        """Run the dialog's action.

        Raises
        ------
        CableTrackerError
            It cannot be done.
        """


class OpenDialog(FormDialog):
    """Asks for a recording on the machine of the server.

    Parameters
    ----------
    template : callable
        Returns the last request, whose other options stay.
    start_hint : str
        Text about the possible initialisations.
    """

    def __init__(
        self,
        template: Callable[[], RecordingRequest],
        opening: Callable[[RecordingRequest], Awaitable[None]],
        start_hint: str,
    ) -> None:
        self._start_hint = start_hint
        self._template = template
        self._opening = opening
        super().__init__("Open a recording", "open")

    def build(self) -> None:
        """Put the fields into it."""
        self._path = _field("path on the server: bag, video, folder or sequence file", "open-path")
        self._path.on("keydown.enter", self.submit)
        self._init = _field(self._start_hint, "open-init")
        self._topic = _field("image topic of a bag that has several", "open-topic")
        self._truth = _field("sequence file with labels", "open-truth")

    def open(self) -> None:
        """Show it with the last request."""
        request = self._template()
        self._path.value = printable(request.path) if request.path != Path() else ""
        self._init.value = request.init
        self._topic.value = request.topic or ""
        self._truth.value = printable(request.truth or "")
        super().open()

    async def do(self) -> None:
        """Open it."""
        template, path = self._template(), typed_path(self._path.value)
        request = replace(
            template.for_other(path),
            init=self._init.value.strip() or template.init,
            topic=self._topic.value.strip() or None,
            truth=typed_path(self._truth.value) if self._truth.value.strip() else None,
        )
        await self._opening(request)


class SaveDialog(FormDialog):
    """Saves parameters on the server or where the browser is.

    Parameters
    ----------
    text : callable
        Returns what is to be saved; raises CableTrackerError if it is not known.
    subject : Subject
        Kind of tracked object; the file is called like its node to begin with.
    """

    def __init__(self, text: Callable[[], Awaitable[str]], subject: Subject) -> None:
        self._text = text
        self._subject = subject
        self._file_name = f"{subject.kind.node}.yaml"
        self._warned_of = ""
        super().__init__("Save the parameters as YAML for the node", "save on the server")

    def build(self) -> None:
        """Put the field into it."""
        self._path = _field("path on the server", "save-path")
        self._path.value = self._file_name
        self._path.on("keydown.enter", self.submit)

    def build_buttons(self) -> None:
        """Offer the file to the browser."""
        ui.button("download", on_click=self._download).props("flat data-test=download")

    def open(self) -> None:
        """Show it."""
        self._warned_of = ""
        super().open()

    async def do(self) -> None:
        """Write the file; one that is there already only the second time."""
        given = self._path.value.strip()
        overwrite, self._warned_of = given == self._warned_of, ""
        path, text = typed_path(given), await self._text()
        try:
            await run.io_bound(write_parameter_file, path, text, self._subject, overwrite=overwrite)
        except ExistingFileError:
            self._warned_of = given
            raise
        ui.notify(f"saved: {path.resolve()}")

    async def _download(self) -> None:
        await self._attempt(self._send)

    async def _send(self) -> None:
        ui.download.content(await self._text(), self._file_name, "application/yaml")


class NumberDialog(FormDialog):
    """Asks in numbers where the cable or the target is.

    Parameters
    ----------
    fields : sequence of (str, float)
        Label of each number, and its value to begin with.
    start : callable
        Starts with these numbers.
    present : callable
        Returns the numbers of the present estimate; None while nothing is claimed.
    """

    def __init__(
        self,
        title: str,
        fields: Sequence[tuple[str, float]],
        start: Callable[[Sequence[float]], Awaitable[None]],
        present: Callable[[], Sequence[float] | None],
    ) -> None:
        self._fields = fields
        self._start = start
        self._present = present
        super().__init__(title, "start")

    def build(self) -> None:
        """Put the fields into it."""
        self._numbers = [
            ui.number(label, value=value).classes("w-full").props("dense")
            for label, value in self._fields
        ]

    def open(self) -> None:
        """Show it with the present estimate."""
        for number, value in zip(self._numbers, self._present() or (), strict=False):
            number.value = round(value, 1)
        super().open()

    async def do(self) -> None:
        """Start there."""
        values = [number.value for number in self._numbers]
        for (label, _), value in zip(self._fields, values, strict=True):
            if value is None:
                raise GuiError(f"{label}: no number is given; type one")
        await self._start(values)


class HelpDialog:
    """Lists the keys.

    Parameters
    ----------
    commands : sequence of KeyBinding
        Key bindings in force.
    pointer : sequence of (str, str)
        Mouse action and its effect.
    """

    def __init__(self, commands: Sequence[KeyBinding], pointer: Sequence[tuple[str, str]]) -> None:
        self.dialog = ui.dialog().props('aria-label="Keys"')
        with self.dialog, ui.card().style("max-width: 640px"):
            ui.label("Keys").classes("text-lg")
            lines = [(command.shown, command.description) for command in commands]
            rows = "".join(
                f"<tr><td><kbd>{keys}</kbd></td><td>{description}</td></tr>"
                for keys, description in (*lines, *pointer)
            )
            ui.html(f'<table class="ct-keys">{rows}</table>', sanitize=False)
            ui.button("close", on_click=self.dialog.close).props("flat")

    def open(self) -> None:
        """Show it."""
        self.dialog.open()


def _field(label: str, test: str) -> ui.input:
    return ui.input(label).classes("w-full").props(f"dense data-test={test}")
