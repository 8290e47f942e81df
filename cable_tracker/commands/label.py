"""`cable-tracker label`."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.commands.console.terminal import console, counted, print_note, progress_bar
from cable_tracker.commands.options.common import (
    OutsideOption,
    RateOption,
    SourceArgument,
    TopicOption,
    open_recording,
)
from cable_tracker.commands.options.serving import (
    DEFAULT_PORT,
    HostOption,
    PortOption,
    announce,
    need_gui,
)
from cable_tracker.errors import RecordingError
from cable_tracker.sequences.source_base import ChosenRecording, Source


def label(  # noqa: PLR0917
    source: SourceArgument,
    labels: Annotated[
        Path | None,
        typer.Option(
            help="File for the labels, in the format that --truth reads. It need not exist."
            "  [default: SOURCE.txt]"
        ),
    ] = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    allow_outside: OutsideOption = False,
    host: HostOption = "127.0.0.1",
    port: PortOption = DEFAULT_PORT,
) -> None:
    """Label a recording by hand, in a browser.

    A label says where the cable is in a frame, or that the frame shows none. The tracker
    proposes, you correct. Nothing is written to the label file before you save.
    """
    window = need_gui("labelling.window")
    workspaces = need_gui("labelling.workspace")
    server = need_gui("web.server")
    # A frame that cannot be decoded is shown with its trouble, and those behind it are labelled.
    chosen = ChosenRecording(source, topic, rate, None, True, allow_outside)
    with open_recording(chosen) as recording:
        _count_frames(recording)
        path = labels if labels is not None else workspaces.default_label_file(recording.path)
        workspace = workspaces.Workspace(recording, path, allow_outside=allow_outside)
        listening = server.listen_on(host, port)

        def started() -> None:
            console.print(f"labels: {workspace.path}", soft_wrap=True)
            announce(listening)

        window.LabelServer(workspace).run(listening, started)
        if workspace.is_changed:
            usual = workspaces.default_label_file(recording.path)
            is_usual = workspace.path.resolve() == usual.resolve()
            command = _command(chosen, None if is_usual else workspace.path)
            print_note(
                f"the labels that were not saved are lost: {workspace.trouble}"
                if workspace.trouble
                else f"the labels are not saved; `{command}` offers them again"
            )


def _command(chosen: ChosenRecording, labels: Path | None) -> str:
    """Return the command that opens a recording and a label file as they were opened here."""
    options = {"--topic": chosen.topic, "--rate": chosen.rate}
    arguments = ["cable-tracker", "label", str(chosen.path)]
    for name, value in options.items():
        arguments += [name, str(value)] if value is not None else []
    arguments += ["--allow-outside"] if chosen.allow_outside else []
    arguments += ["--labels", str(labels)] if labels is not None else []
    return shlex.join(arguments)


def _count_frames(recording: Source) -> None:
    """Learn how many frames there are where the recording does not say."""
    if recording.frame_count is not None:
        return
    count = 0
    with progress_bar("counting frames", None) as progress:
        try:
            for _ in counted(recording.frames(), progress):
                count += 1
        except RecordingError as error:
            if not count:
                raise
            print_note(str(error))
    recording.frame_count = count
