"""Options that several commands have."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.commands.terminal import messages
from cable_tracker.detection.detectors import DETECTORS
from cable_tracker.sequences.source import Source, open_source


class Storage(str, Enum):
    """Formats of a bag's storage file."""

    MCAP = "mcap"
    SQLITE3 = "sqlite3"


PresetName = Enum("PresetName", {name: name for name in PRESETS}, type=str)  # type: ignore[misc]
InitOption = Annotated[
    str | None,
    typer.Option(
        help="Where to start: `random`, `truth` (label of the first frame), the name of a"
        f" detector ({', '.join(DETECTORS)}), or `d,alpha,w,beta` in px and rad."
        "  [default: random]"
    ),
]
PresetOption = Annotated[
    PresetName | None,
    typer.Option("--preset", help="Values to start from.  [default: default]"),
]
ParamsOption = Annotated[
    Path | None, typer.Option(help="YAML file with parameters, as the node reads them.")
]
SeedOption = Annotated[
    int | None, typer.Option(help="Seed of the random numbers, instead of the preset's.")
]
SourceArgument = Annotated[
    Path,
    typer.Argument(
        help="Recording: a ROS 2 or ROS 1 bag, a video, a folder of images, or a sequence file."
    ),
]
TopicOption = Annotated[
    str | None, typer.Option(help="Image topic of a bag; needed only where it has several.")
]
RateOption = Annotated[
    float, typer.Option(help="Frames per second of image folders, which have no times.")
]
TruthOption = Annotated[
    Path | None,
    typer.Option(
        help="Sequence file with labels; they take the place of all that the recording holds."
    ),
]
SkipOption = Annotated[
    bool,
    typer.Option("--skip-bad-frames", help="Go on where a frame cannot be decoded."),
]
OutsideOption = Annotated[
    bool,
    typer.Option(
        "--allow-outside", help="Let a sequence file name pictures and videos outside its folder."
    ),
]
ForceOption = Annotated[
    bool, typer.Option("--force", help="Replace an output of the same kind that exists already.")
]


def open_recording(  # noqa: PLR0917
    path: Path,
    topic: str | None,
    rate: float,
    truth: Path | None,
    skip_bad_frames: bool,
    allow_outside: bool,
) -> Source:
    """Open a source, and say what the user should know about it."""
    source = open_source(
        path,
        topic=topic,
        rate=rate,
        truth=truth,
        skip_bad_frames=skip_bad_frames,
        allow_outside=allow_outside,
    )
    if source.note:
        messages.print(f"note: {path}: {source.note}", soft_wrap=True)
    return source
