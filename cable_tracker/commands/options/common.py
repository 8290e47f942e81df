"""Options that several commands have."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.commands.console.terminal import console, print_note
from cable_tracker.detection.baselines.detectors import DETECTORS
from cable_tracker.errors import ParameterError
from cable_tracker.metric.recorded_instruments import RecordedVehicle, recorded_vehicle
from cable_tracker.sequences.bags.instruments import NO_TOPIC, Instrument, InstrumentChoice
from cable_tracker.sequences.source import open_chosen
from cable_tracker.sequences.source_base import ChosenRecording, Source
from cable_tracker.stamps import USUAL_RATE
from cable_tracker.target.parameters.presets import TARGET_PRESETS

PresetName = StrEnum("PresetName", list(PRESETS))  # type: ignore[misc]
TargetPresetName = StrEnum("TargetPresetName", list(TARGET_PRESETS))  # type: ignore[misc]
InitOption = Annotated[
    str | None,
    typer.Option(
        help="Where to start: `random`, `truth` (label of the first frame), the name of a"
        f" detector ({', '.join(DETECTORS)}), or `d,alpha,w,beta` in px and rad."
        "  [default: random]"
    ),
]
_START_PRESET = typer.Option(
    "--preset", help="Values to start from; --params wins.  [default: default]"
)
PresetOption = Annotated[PresetName | None, _START_PRESET]
TargetPresetOption = Annotated[TargetPresetName | None, _START_PRESET]
ParamsOption = Annotated[
    Path | None, typer.Option(help="YAML file with parameters, as the node reads them.")
]
SeedOption = Annotated[
    int | None, typer.Option(help="Seed of the random numbers; wins over that of --params.")
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
    float | None,
    typer.Option(
        help=f"Frames per second of image folders, which have no times.  [default: {USUAL_RATE:g}]"
    ),
]
TruthOption = Annotated[
    Path | None,
    typer.Option(
        help="Labels: a sequence file, or a bag with `ground_truth`. They take the place of all"
        " that the recording holds."
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
VehicleOption = Annotated[
    Path | None,
    typer.Option(
        "--vehicle",
        help="YAML file with mounting, calibration and standard deviations of instruments, where"
        " the bag does not hold them."
        "  [default: vehicle.yaml in the bag's folder]",
    ),
]
CameraInfoOption = Annotated[
    str | None, typer.Option("--camera-info-topic", help="Calibration, or `none`; else by type.")
]
AltitudeOption = Annotated[
    str | None, typer.Option("--altitude-topic", help="Altitude, or `none`; else by type.")
]
ImuOption = Annotated[
    str | None, typer.Option("--imu-topic", help="Roll and pitch, or `none`; else by type.")
]
OdometryOption = Annotated[
    str | None, typer.Option("--odometry-topic", help="Odometry, or `none`; else by type.")
]
FixOption = Annotated[
    str | None, typer.Option("--fix-topic", help="NavSatFix, or `none`; else by type.")
]
BagOption = Annotated[
    bool, typer.Option("--bag/--no-bag", help="Write the bag with the node's messages.")
]
VideoOption = Annotated[
    bool, typer.Option("--video/--no-video", help="Write the video overlay.webm.")
]
PicturesOption = Annotated[
    bool,
    typer.Option("--pictures/--no-pictures", help="Write the contact sheet and, if any, plots."),
]
TimingOption = Annotated[
    bool, typer.Option(help="Fill the column `ms`, the only one that differs from run to run.")
]
ForceOption = Annotated[
    bool, typer.Option("--force", help="Replace an output of the same kind that exists already.")
]


def parse_size(text: str) -> tuple[int, int]:
    """Read an image size such as 320x240.

    Raises
    ------
    ParameterError
        The text is no size.
    """
    width, separator, height = text.lower().partition("x")
    if not separator or not width.isdecimal() or not height.isdecimal():
        raise ParameterError(
            f"size: {text!r} is not of the form 320x240; give width x height in px"
        )
    return int(width), int(height)


def chosen_instruments(
    camera_info: str | None,
    altitude: str | None,
    imu: str | None,
    odometry: str | None,
    fix: str | None = NO_TOPIC,
) -> InstrumentChoice:
    """Return the topics that the user named for the instruments; None: found by their type."""
    named = (camera_info, altitude, imu, odometry, fix)
    pairs = zip(Instrument, named, strict=True)
    return InstrumentChoice({instrument: topic for instrument, topic in pairs if topic is not None})


def find_vehicle(
    source: Source, choice: InstrumentChoice, vehicle_file: Path | None
) -> RecordedVehicle:
    """Find the instruments of a recording, and say what the user should know about them."""
    found = recorded_vehicle(source, choice, vehicle_file)
    print_notes(source.path, found.notes)
    return found


def refuse_without_effect(given: Mapping[str, object], why: str) -> None:
    """Refuse options that would have no effect.

    Parameters
    ----------
    given : mapping of str to object
        Values of such options by name; None or False: it was not given.
    why : str
        Why they have none, to follow their names.

    Raises
    ------
    ParameterError
        One of them was given.
    """
    names = [name for name, value in given.items() if value is not None and value is not False]
    if names:
        word = "it" if len(names) == 1 else "them"
        raise ParameterError(f"{' and '.join(names)} {why}; leave {word} out")


def open_recording(recording: ChosenRecording) -> Source:
    """Open a recording, and say what the user should know about it."""
    source = open_chosen(recording)
    print_notes(recording.path, [source.note] if source.note else [])
    print_needless_rate(source, recording.rate)
    return source


def print_taken_rate(source: Source) -> None:
    """Say at which rate pictures are taken, which have no times of their own."""
    if source.taken_rate is not None:
        console.print(
            f"pictures have no times and were taken to be {source.taken_rate:g} a second (--rate)",
            soft_wrap=True,
        )


def print_needless_rate(source: Source, rate: float | None) -> None:
    """Say that a rate was given for frames that have times of their own."""
    if rate is not None and source.taken_rate is None:
        print_notes(source.path, ["its frames have times of their own: --rate does nothing"])


def print_notes(path: Path, notes: Iterable[str]) -> None:
    """Say what the user should know about a recording, each note on a line of its own."""
    for note in notes:
        print_note(f"{path}: {note}")
