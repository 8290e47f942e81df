"""The command `cable-tracker`."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from enum import Enum
from pathlib import Path
from types import ModuleType
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from cable_tracker import __version__
from cable_tracker.cable.initial_state_text import RANDOM
from cable_tracker.cable.parameter_files import (
    filter_parameters,
    format_parameter_file,
    read_parameter_file,
)
from cable_tracker.cable.parameters import PARAMETER_TABLE, ParameterSpec, TrackerParameters
from cable_tracker.cable.presets import PRESETS, preset
from cable_tracker.cable.tracker import CableTracker
from cable_tracker.errors import CableTrackerError, ParameterError, RecordingError, RosError
from cable_tracker.evaluation.metrics import ErrorSummary, summarise_errors
from cable_tracker.evaluation.result_folder import (
    BAG,
    CONTACT_SHEET,
    ESTIMATES,
    PLOTS,
    VIDEO,
    ResultFolder,
)
from cable_tracker.evaluation.track_recording import (
    initial_state_for,
    start_from,
    track_recording,
)
from cable_tracker.node_parameter_tables import TRACKER_NODE_PARAMETERS
from cable_tracker.sequences.convert import ImageFormat, write_bag
from cable_tracker.sequences.estimates import REFUSED
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.image_writer import write_sequence
from cable_tracker.sequences.source import Source, open_source
from cable_tracker.simulation.scenario import SimulationSettings, simulate

EXIT_USER_ERROR = 2

app = typer.Typer(
    name="cable-tracker",
    help="Follow an underwater cable or pipeline by camera, with a particle filter.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
console = Console(markup=False, highlight=False)
messages = Console(stderr=True, markup=False, highlight=False)


class Storage(str, Enum):
    """Formats of a bag's storage file."""

    MCAP = "mcap"
    SQLITE3 = "sqlite3"


class SimulationFormat(str, Enum):
    """What `simulate` writes."""

    BAG = "bag"
    SEQUENCE = "sequence"


PresetName = Enum("PresetName", {name: name for name in PRESETS}, type=str)  # type: ignore[misc]

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
    typer.Option(help="Sequence file with labels for a recording that has none of its own."),
]
SkipOption = Annotated[
    bool,
    typer.Option("--skip-bad-frames", help="Go on where a frame cannot be decoded."),
]
ForceOption = Annotated[
    bool, typer.Option("--force", help="Replace an output of the same kind that exists already.")
]


def show_version(wanted: bool) -> None:
    """Print the version and end."""
    if wanted:
        console.print(f"cable-tracker {__version__}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[
        bool,
        typer.Option("--version", callback=show_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    """Follow an underwater cable or pipeline by camera, with a particle filter."""


@contextmanager
def progress_bar(description: str, total: int | None) -> Iterator[Progress]:
    """Show a progress bar on the terminal; nothing where there is none."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    # Off a terminal the bar would leave an empty line among the messages.
    hidden = not messages.is_terminal
    with Progress(*columns, console=messages, transient=True, disable=hidden) as progress:
        progress.add_task(description, total=total)
        yield progress


def advance(progress: Progress) -> None:
    """Move the only task of a progress bar by one."""
    progress.advance(progress.task_ids[0])


def open_recording(
    path: Path, topic: str | None, rate: float, truth: Path | None, skip_bad_frames: bool
) -> Source:
    """Open a source, and say what the user should know about it."""
    source = open_source(path, topic=topic, rate=rate, truth=truth, skip_bad_frames=skip_bad_frames)
    if source.note:
        messages.print(f"note: {source.note}", soft_wrap=True)
    return source


def chosen_parameters(
    preset_name: str | None, values: dict[str, object], seed: int | None
) -> TrackerParameters:
    """Combine preset, the values of a parameter file, and seed; options win over the file."""
    node_only = {spec.name for spec in TRACKER_NODE_PARAMETERS}
    base = preset(preset_name or str(values.get("preset", "default")))
    parameters = filter_parameters(base, values, node_only)
    if seed is not None:
        parameters = parameters.replaced({"seed": seed})
    return parameters


def chosen_start(init: str | None, values: dict[str, object]) -> str:
    """Return the words that say where to start; the option wins over the parameter file."""
    return init if init is not None else str(values.get("initial_state", RANDOM))


def default_output(source: Path) -> Path:
    """Return the folder for results when the user names none."""
    resolved = source.resolve()
    stem = resolved.name if resolved.is_dir() else resolved.stem
    return Path(f"{stem}_tracked")


@app.command()
def track(  # noqa: PLR0917
    source: SourceArgument,
    ros: Annotated[
        bool,
        typer.Option(
            "--ros", help="Use the ROS nodes `replay` and `tracker`, in lockstep over DDS."
        ),
    ] = False,
    init: Annotated[
        str | None,
        typer.Option(
            help="Where to start: `random`, `truth` (label of the first frame), or"
            " `d,alpha,w,beta` in px and rad.  [default: random]"
        ),
    ] = None,
    preset_name: Annotated[
        PresetName | None,
        typer.Option("--preset", help="Values to start from.  [default: default]"),
    ] = None,
    params: Annotated[
        Path | None, typer.Option(help="YAML file with parameters, as the node reads them.")
    ] = None,
    seed: Annotated[
        int | None, typer.Option(help="Seed of the random numbers, instead of the preset's.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option(help="Folder for the results.  [default: SOURCE_tracked]")
    ] = None,
    force: ForceOption = False,
    topic: TopicOption = None,
    rate: RateOption = 25.0,
    truth: TruthOption = None,
    skip_bad_frames: SkipOption = False,
    timing: Annotated[
        bool,
        typer.Option(help="Fill the column `ms`, the only one that differs from run to run."),
    ] = True,
) -> None:
    """Track a recording and write table, pictures, video and bag into one folder.

    With ground truth, a table of errors is printed. The same recording, parameters and seed give
    the same estimates, with --ros and without.
    """
    values = read_parameter_file(params) if params is not None else {}
    parameters = chosen_parameters(preset_name.value if preset_name else None, values, seed)
    folder = output if output is not None else default_output(source)
    with ExitStack() as stack:
        recording = stack.enter_context(open_recording(source, topic, rate, truth, skip_bad_frames))
        state = initial_state_for(recording, chosen_start(init, values))
        results = stack.enter_context(ResultFolder(folder, overwrite=force, timing=timing))
        progress = stack.enter_context(progress_bar("tracking", recording.frame_count))
        if ros:
            ros_module = _ros_tracking()
            request = ros_module.RecordingRequest(
                source={
                    "source": str(source.resolve()),
                    "topic": topic or "",
                    "frame_rate": rate,
                    "truth": str(truth.resolve()) if truth else "",
                    "skip_bad_frames": skip_bad_frames,
                },
                parameters=parameters,
                initial_state=state,
            )
            damage = ros_module.track_recording_over_ros(
                recording, request, results, lambda: advance(progress)
            )
        else:
            tracker = CableTracker(parameters)
            start_from(tracker, state)
            damage = track_recording(recording, tracker, results, lambda: advance(progress))
        _need_usable_frames(results, damage)
    _print_results(results)
    if damage is not None:
        raise damage


def _ros_tracking() -> ModuleType:
    """Import the ROS part only when it is asked for: everything else works without ROS."""
    try:
        from cable_tracker.ros import track_recording as module  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise RosError(
            f"ROS 2 is not installed (no module {error.name}); run"
            " `pip install cable_tracker[ros]` or source /opt/ros/jazzy/setup.bash"
        ) from error
    return module


def _need_usable_frames(results: ResultFolder, damage: RecordingError | None) -> None:
    if any(row.status != REFUSED for row in results.rows):
        return
    reason = "holds no frames"
    if results.rows:
        reason = f"none of the {len(results.rows)} frames can be used"
    raise damage or RecordingError(f"the recording {reason}; record it again")


def _print_results(results: ResultFolder) -> None:
    statuses = [row.status for row in results.rows]
    counts = {status: statuses.count(status) for status in dict.fromkeys(statuses)}
    words = ", ".join(f"{count} {status}" for status, count in counts.items())
    console.print(f"{len(results.rows)} frames: {words}", soft_wrap=True)
    times = sorted(row.ms for row in results.rows if row.ms is not None)
    if times:
        console.print(f"median time in the tracker: {times[len(times) // 2]:.2f} ms per frame")
    if results.truths:
        _print_errors(summarise_errors(results.rows, results.truths))
    for name in (ESTIMATES, VIDEO, CONTACT_SHEET, PLOTS, BAG):
        console.print(f"  {results.path / name}", soft_wrap=True)


def _print_errors(summary: ErrorSummary) -> None:
    console.print(
        f"{summary.claimed} of {summary.labelled} labelled frames claimed;"
        f" {summary.share_off:.1%} of those off by more than w/2 or 8 deg"
        if summary.claimed
        else f"none of {summary.labelled} labelled frames claimed",
        soft_wrap=True,
    )
    if not summary.claimed:
        return
    table = Table(title="errors against ground truth")
    for heading in ("", "bias", "RMSE", "median", "95th percentile"):
        table.add_column(heading, justify="right")
    degree = math.degrees(1.0)
    rows = (("d [px]", 1.0), ("alpha [deg]", degree), ("w [px]", 1.0), ("beta [deg]", degree))
    columns = (summary.bias, summary.rmse, summary.median, summary.percentile_95)
    for index, (name, scale) in enumerate(rows):
        table.add_row(name, *(f"{column[index] * scale:.2f}" for column in columns))
    console.print(table)


@app.command()
def convert(  # noqa: PLR0917
    source: SourceArgument,
    output: Annotated[Path, typer.Argument(help="Folder of the bag to write.")],
    storage: Annotated[Storage, typer.Option(help="Format of the bag.")] = Storage.MCAP,
    image_format: Annotated[
        ImageFormat, typer.Option("--format", help="Pixels: as recorded, grey, or JPEG.")
    ] = ImageFormat.AS_IS,
    topic: TopicOption = None,
    rate: RateOption = 25.0,
    truth: TruthOption = None,
    skip_bad_frames: SkipOption = False,
    force: ForceOption = False,
) -> None:
    """Convert any recording into a ROS 2 bag, with its ground truth if it has some."""
    with ExitStack() as stack:
        recording = stack.enter_context(open_recording(source, topic, rate, truth, skip_bad_frames))
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


def counted(frames: Iterable[Frame], progress: Progress) -> Iterator[Frame]:
    """Move the progress bar with every frame that passes."""
    for frame in frames:
        yield frame
        advance(progress)


def parse_size(text: str) -> tuple[int, int]:
    """Read an image size such as 320x240.

    Raises
    ------
    ParameterError
        It is none.
    """
    width, separator, height = text.lower().partition("x")
    if not separator or not width.isdecimal() or not height.isdecimal():
        raise ParameterError(f"size: {text!r} is not of the form 320x240")
    return int(width), int(height)


@app.command(name="simulate")
def simulate_command(  # noqa: PLR0917
    output: Annotated[Path, typer.Argument(help="Folder to write.")],
    output_format: Annotated[
        SimulationFormat,
        typer.Option("--format", help="A ROS 2 bag, or PNGs with a sequence file."),
    ] = SimulationFormat.BAG,
    frames: Annotated[int, typer.Option(help="Number of frames.")] = 300,
    rate: Annotated[float, typer.Option(help="Frames per second.")] = 25.0,
    size: Annotated[str, typer.Option(help="Width and height in px.")] = "320x240",
    clutter: Annotated[
        float, typer.Option(help="How overgrown, buried and distracting it is, 0 to 1.")
    ] = 0.5,
    seed: Annotated[int, typer.Option(help="Seed: the same one gives the same frames.")] = 0,
    storage: Annotated[Storage, typer.Option(help="Format of the bag.")] = Storage.MCAP,
    force: ForceOption = False,
) -> None:
    """Simulate a dive over a cable on a textured sea bed, with exact ground truth."""
    settings = SimulationSettings(
        frame_count=frames, rate=rate, image_size=parse_size(size), clutter=clutter, seed=seed
    )
    with progress_bar("simulating", frames) as progress:
        dive = counted(simulate(settings), progress)
        if output_format is SimulationFormat.BAG:
            count = write_bag(output, dive, storage=storage.value, overwrite=force).count
        else:
            count = write_sequence(output, dive, overwrite=force)
    console.print(f"{count} frames: {output}", soft_wrap=True)


class ParameterFormat(str, Enum):
    """How `parameters` prints."""

    TABLE = "table"
    YAML = "yaml"


@app.command()
def parameters(
    preset_name: Annotated[
        PresetName, typer.Option("--preset", help="Whose values to print.")
    ] = PresetName.default,  # type: ignore[attr-defined]
    output_format: Annotated[
        ParameterFormat, typer.Option("--format", help="A table to read, or a file for the node.")
    ] = ParameterFormat.TABLE,
) -> None:
    """Print all parameters of the filter, with unit, range and meaning."""
    values = preset(preset_name.value)
    if output_format is ParameterFormat.YAML:
        print(format_parameter_file(values, f"Preset `{preset_name.value}`."), end="")
        return
    table = Table(show_lines=False)
    for heading in ("name", "value", "unit", "range", "meaning"):
        table.add_column(heading, no_wrap=heading == "name")
    for spec in PARAMETER_TABLE:
        table.add_row(*_cells(spec, values))
    console.print(table)


def _cells(spec: ParameterSpec, values: TrackerParameters) -> tuple[str, str, str, str, str]:
    value = str(values.as_mapping()[spec.name])
    return spec.name, value, spec.unit, spec.range_text(), spec.meaning


def main() -> None:
    """Run the command; a user's error is one line and exit code 2."""
    try:
        app()
    except CableTrackerError as error:
        messages.print(f"error: {error}", style="bold red", soft_wrap=True)
        sys.exit(EXIT_USER_ERROR)


if __name__ == "__main__":
    main()
