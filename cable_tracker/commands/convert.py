"""`cable-tracker convert`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from itertools import count
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.commands.console.terminal import console, counted, progress_bar
from cable_tracker.commands.options.common import (
    AltitudeOption,
    CameraInfoOption,
    FixOption,
    ForceOption,
    ImuOption,
    OdometryOption,
    OutsideOption,
    RateOption,
    SkipOption,
    SourceArgument,
    TopicOption,
    TruthOption,
    chosen_instruments,
    open_recording,
    print_notes,
)
from cable_tracker.errors import OutputError, RecordingError, read_failure
from cable_tracker.metric.recorded_instruments import own_vehicle_file
from cable_tracker.sequences.bags.bag import BagSource
from cable_tracker.sequences.bags.bag_writer import StorageFormat, kept_notes
from cable_tracker.sequences.bags.convert import ImageFormat, carried_messages, write_bag
from cable_tracker.sequences.bags.instrument_source import InstrumentSource
from cable_tracker.sequences.bags.instruments import InstrumentChoice, refuse_named_topics
from cable_tracker.sequences.bags.storage_files import storage_files
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.labels.target_labels import own_boxes
from cable_tracker.sequences.source_base import ChosenRecording, Source

LEVEL_STRIDE = 10
"""Stride of the frames from which the levels of a recording are taken."""


def convert(  # noqa: PLR0917
    source: SourceArgument,
    output: Annotated[Path, typer.Argument(help="Folder of the bag to write.")],
    storage: Annotated[StorageFormat, typer.Option(help="Format of the bag.")] = StorageFormat.MCAP,
    image_format: Annotated[
        ImageFormat, typer.Option("--format", help="Pixels: as recorded, grey, or JPEG.")
    ] = ImageFormat.AS_IS,
    topic: TopicOption = None,
    rate: RateOption = None,
    truth: TruthOption = None,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
    camera_info_topic: CameraInfoOption = None,
    altitude_topic: AltitudeOption = None,
    imu_topic: ImuOption = None,
    odometry_topic: OdometryOption = None,
    fix_topic: FixOption = None,
    force: ForceOption = False,
) -> None:
    """Convert any recording into a ROS 2 bag.

    Its ground truth is written too, if it has some, of a target the boxes. Of a bag, the messages
    of its instruments and /tf_static are carried along on their topics, and vehicle.yaml is copied;
    other topics are left out.
    """
    choice = chosen_instruments(
        camera_info_topic, altitude_topic, imu_topic, odometry_topic, fix_topic
    )
    chosen = ChosenRecording(source, topic, rate, truth, skip_bad_frames, allow_outside)
    with ExitStack() as stack:
        recording = stack.enter_context(open_recording(chosen))
        instruments = _instruments(recording, choice)
        boxes = own_boxes(recording)
        # The bag may be written in the place of the recording.
        vehicle = _vehicle_file(recording)
        kept = kept_notes(output) if force and vehicle is None else []
        progress = stack.enter_context(progress_bar("converting", recording.frame_count))
        is_in_place = recording.path.resolve().is_relative_to(output.resolve())
        if is_in_place:
            _refuse_a_part(recording.path, output)
        with _noting_that_nothing_is_changed() if is_in_place else nullcontext():
            written = write_bag(
                output,
                counted(recording.frames(), progress),
                storage=storage,
                image_format=image_format,
                level_frames=_every_tenth(recording),
                skip_bad_frames=skip_bad_frames,
                overwrite=force,
                carried=() if instruments is None else carried_messages(instruments),
                boxes=boxes,
                vehicle=vehicle,
                keeps_beginning=not is_in_place,
            )
    print_notes(output, kept)
    if instruments is not None:
        print_notes(source, instruments.remarks())
    if written.gain > 1.0:
        print_notes(source, [_gain_note(written.gain)])
    skipped = f" ({written.skipped} that cannot be decoded left out)" if written.skipped else ""
    console.print(f"{written.count} frames{skipped}: {output}", soft_wrap=True)
    if written.damage is not None:
        raise written.damage


def _refuse_a_part(path: Path, output: Path) -> None:
    """Refuse to put one file of a bag in the place of the whole bag.

    Raises
    ------
    OutputError
        The bag has other files.
    """
    others = [file.name for file in storage_files(output) if not path.samefile(file)]
    if path.is_file() and others:
        raise OutputError(
            f"{output}: holds {others[0]} besides {path.name}, which would be deleted; convert the"
            " whole folder, or choose another name"
        )


@contextmanager
def _noting_that_nothing_is_changed() -> Iterator[None]:
    """Add to an error that the recording, which was to be replaced, is unchanged."""
    try:
        yield
    except RecordingError as error:
        error.add_note(
            "the recording is as it was: a bag of the frames before that would have replaced it"
        )
        raise


def _every_tenth(recording: Source) -> Iterator[Frame]:
    """Read some frames of a recording, to take its levels from."""
    numbers = count()
    return recording.chosen_frames(lambda _stamp: next(numbers) % LEVEL_STRIDE == 0)


def _gain_note(gain: float) -> str:
    return (
        "its pictures have more than 8 bits and use less than 1/8 of that range: for 8 bits the"
        f" levels of all frames were multiplied by {gain:g}; leave out --format, which keeps the"
        " pixels as recorded"
    )


def _instruments(recording: Source, choice: InstrumentChoice) -> InstrumentSource | None:
    """Find the instruments of a bag, and say of which topics none could be chosen."""
    if not isinstance(recording, BagSource):
        refuse_named_topics(recording.path, choice)
        return None
    found = InstrumentSource(recording.path, recording.storage, recording.topic, choice)
    print_notes(recording.path, found.found.notes)
    return found


def _vehicle_file(recording: Source) -> bytes | None:
    """Return the content of a recording's `vehicle.yaml`; None if it has none."""
    path = own_vehicle_file(recording.path)
    try:
        return path.read_bytes() if path.is_file() else None
    except OSError as error:
        raise read_failure(path, error) from error
