"""Options that several commands have."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.commands.terminal import messages
from cable_tracker.detection.detectors import DETECTORS
from cable_tracker.metric.recorded import RecordedVehicle, recorded_vehicle
from cable_tracker.sequences.instruments import Instrument, InstrumentChoice
from cable_tracker.sequences.source import Source, open_source


class Storage(str, Enum):
    """Formats of a bag's storage file."""

    MCAP = "mcap"
    SQLITE3 = "sqlite3"


SchedulerOption = Annotated[
    str | None, typer.Option(help="Address of a running Dask scheduler: tcp://host:8786.")
]
MemoryOption = Annotated[str, typer.Option(help="Most memory of each worker.")]
DashboardOption = Annotated[
    bool, typer.Option("--dashboard", help="Serve Dask's pages at 127.0.0.1:8787.")
]
ResumeOption = Annotated[
    bool, typer.Option("--resume", help="Do only what is missing or has changed.")
]
MEMORY = "4 GiB"

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
        help="YAML file with mounting, calibration and doubts, where the bag does not hold them."
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
ForceOption = Annotated[
    bool, typer.Option("--force", help="Replace an output of the same kind that exists already.")
]


def chosen_instruments(
    camera_info: str | None = None,
    altitude: str | None = None,
    imu: str | None = None,
    odometry: str | None = None,
    fix: str | None = None,
) -> InstrumentChoice:
    """Return which topics the user named for the instruments."""
    named = (camera_info, altitude, imu, odometry, fix)
    pairs = zip(Instrument, named, strict=True)
    return InstrumentChoice({instrument: topic for instrument, topic in pairs if topic is not None})


def find_vehicle(
    source: Source, choice: InstrumentChoice, vehicle_file: Path | None
) -> RecordedVehicle:
    """Find the instruments of a recording, and say what the user should know about them."""
    found = recorded_vehicle(source, choice, vehicle_file)
    for note in found.notes:
        messages.print(f"note: {source.path}: {note}", soft_wrap=True)
    return found


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
