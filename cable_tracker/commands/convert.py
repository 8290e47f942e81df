"""`cable-tracker convert`."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.commands.options import (
    ForceOption,
    OutsideOption,
    RateOption,
    SkipOption,
    SourceArgument,
    Storage,
    TopicOption,
    TruthOption,
    open_recording,
)
from cable_tracker.commands.terminal import console, counted, progress_bar
from cable_tracker.sequences.convert import ImageFormat, write_bag
from cable_tracker.sequences.source import ChosenRecording
from cable_tracker.stamps import USUAL_RATE


def convert(  # noqa: PLR0917
    source: SourceArgument,
    output: Annotated[Path, typer.Argument(help="Folder of the bag to write.")],
    storage: Annotated[Storage, typer.Option(help="Format of the bag.")] = Storage.MCAP,
    image_format: Annotated[
        ImageFormat, typer.Option("--format", help="Pixels: as recorded, grey, or JPEG.")
    ] = ImageFormat.AS_IS,
    topic: TopicOption = None,
    rate: RateOption = USUAL_RATE,
    truth: TruthOption = None,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
    force: ForceOption = False,
) -> None:
    """Convert any recording into a ROS 2 bag.

    Its ground truth is written too, if it has some.
    """
    chosen = ChosenRecording(source, topic, rate, truth, skip_bad_frames, allow_outside)
    with ExitStack() as stack:
        recording = stack.enter_context(open_recording(chosen))
        progress = stack.enter_context(progress_bar("converting", recording.frame_count))
        written = write_bag(
            output,
            counted(recording.frames(), progress),
            storage=storage.value,
            image_format=image_format,
            skip_bad_frames=skip_bad_frames,
            overwrite=force,
        )
    skipped = f" ({written.skipped} that cannot be decoded left out)" if written.skipped else ""
    console.print(f"{written.count} frames{skipped}: {output}", soft_wrap=True)
    if written.damage is not None:
        raise written.damage
