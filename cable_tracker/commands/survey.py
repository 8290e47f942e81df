"""`cable-tracker survey`."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from cable_tracker.campaigns.folder_tasks import TaskState
from cable_tracker.commands.console.terminal import advance, console, print_table, progress_bar
from cable_tracker.commands.options.common import (
    AltitudeOption,
    CameraInfoOption,
    FixOption,
    ForceOption,
    ImuOption,
    OdometryOption,
    ParamsOption,
    PresetOption,
    RateOption,
    SeedOption,
    TopicOption,
    VehicleOption,
    chosen_instruments,
)
from cable_tracker.commands.options.many_runs import (
    MEMORY,
    DashboardOption,
    MemoryOption,
    ResumeOption,
    SchedulerOption,
    chosen_cluster,
    with_whole_paths,
)
from cable_tracker.commands.options.parameters import chosen_parameters
from cable_tracker.errors import OutputError, ParameterError, RecordingError
from cable_tracker.followed_kinds import CABLE
from cable_tracker.survey.campaign import REPORT, SurveyResult, holds_survey, run_survey
from cable_tracker.survey.forward_pass import MOST_RATE, ForwardSettings
from cable_tracker.survey.outputs.surveyed_dive import RECORDINGS
from cable_tracker.survey.recording import SurveySettings
from cable_tracker.survey.routes.events import Limits


def survey(  # noqa: PLR0917
    recordings: Annotated[
        list[Path], typer.Argument(help="Recordings: bags with odometry, calibration, altitude.")
    ],
    output: Annotated[Path, typer.Option(help="Folder for the results.")],
    datum: Annotated[
        str | None,
        typer.Option(
            help="Latitude,longitude of the local frame's origin in degrees."
            "  [default: with --resume that of the earlier results, else the first fix]"
        ),
    ] = None,
    resume: ResumeOption = False,
    force: ForceOption = False,
    workers: Annotated[int, typer.Option(help="Processes on this machine.")] = 1,
    scheduler: SchedulerOption = None,
    memory: MemoryOption = MEMORY,
    dashboard: DashboardOption = False,
    pictures: Annotated[bool, typer.Option(help="Keep a picture of each event.")] = True,
    least_burial: Annotated[
        float, typer.Option(help="Length of the shortest buried stretch that is reported [m].")
    ] = 1.0,
    bend_radius: Annotated[
        float, typer.Option(help="Radius below which a bend is an event [m]; 0: never.")
    ] = 10.0,
    most_aside: Annotated[
        float,
        typer.Option(help="Distance beside the cable above which the vehicle is too far off [m]."),
    ] = 1.2,
    most_rate: Annotated[
        float,
        typer.Option(
            help="With odometry, largest number of pictures per second that are tracked; 0: all."
        ),
    ] = MOST_RATE,
    preset_name: PresetOption = None,
    params: ParamsOption = None,
    seed: SeedOption = None,
    topic: TopicOption = None,
    rate: RateOption = None,
    vehicle: VehicleOption = None,
    camera_info_topic: CameraInfoOption = None,
    altitude_topic: AltitudeOption = None,
    imu_topic: ImuOption = None,
    odometry_topic: OdometryOption = None,
    fix_topic: FixOption = None,
) -> None:
    """Map the cable from dives: its route, events, and a report.

    Each recording is tracked forwards and smoothed backwards; dives over the same cable are merged.
    """
    _, parameters = chosen_parameters(CABLE, preset_name, params, {}, seed)
    forward = ForwardSettings(
        parameters=with_whole_paths(parameters),
        topic=topic,
        rate=rate,
        choice=chosen_instruments(
            camera_info_topic, altitude_topic, imu_topic, odometry_topic, fix_topic
        ),
        vehicle=vehicle and vehicle.absolute(),
        most_rate=most_rate,
    )
    limits = Limits(least_burial=least_burial, bend_radius=bend_radius, most_aside=most_aside)
    settings = SurveySettings(forward, limits, parse_datum(datum), pictures)
    _check_output(recordings, output, resume, force)
    cluster = chosen_cluster(workers, scheduler, memory, dashboard)
    begin = time.monotonic()
    with progress_bar("surveying", None) as progress:
        result = run_survey(
            recordings, output, settings, cluster,
            resume=resume, advance=partial(advance, progress),
        )  # fmt: skip
    _print(result, output, time.monotonic() - begin)
    if all(row.state != "done" for row in result.rows):
        kept = f"; the earlier map in {output} is as it was" if result.is_earlier_map_kept else ""
        raise RecordingError(
            f"none of the {len(result.rows)} recordings could be surveyed; the reasons stand"
            f" above{kept}"
        )


def parse_datum(text: str | None) -> tuple[float, float] | None:
    """Read a datum such as 54.25,7.9.

    Raises
    ------
    ParameterError
        The text is no datum.
    """
    if text is None:
        return None
    try:
        latitude, longitude = (float(part) for part in text.split(","))
    except ValueError as error:
        raise ParameterError(
            f"datum: {text!r} is not of the form 54.25,7.9; give latitude,longitude in degrees"
        ) from error
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 360.0):
        raise ParameterError(
            f"datum: {text} is no place on the earth; give latitude,longitude in degrees"
        )
    return latitude, longitude


def _check_output(recordings: Sequence[Path], output: Path, resume: bool, force: bool) -> None:
    """Refuse to write over anything but an earlier survey, and over that unless it is wanted."""
    results = (output / RECORDINGS).resolve()
    for path in recordings:
        if path.resolve().is_relative_to(results):
            raise OutputError(
                f"{path}: lies where the results in {output} go, and would be replaced by them;"
                " choose another folder for --output"
            )
    if not output.exists() or (output.is_dir() and _holds_nothing(output)):
        return
    if not holds_survey(output):
        raise OutputError(f"{output}: is no earlier survey and is not overwritten; choose another")
    if not (resume or force):
        raise OutputError(
            f"{output}: holds a survey; go on with --resume, or do it again with --force"
        )


def _holds_nothing(output: Path) -> bool:
    """Tell whether nothing lies in a folder, or what a survey leaves that has ended at once."""
    found = list(output.iterdir())
    results = output / RECORDINGS
    return not found or (found == [results] and results.is_dir() and not any(results.iterdir()))


def _states(result: SurveyResult) -> str:
    """Return how many recordings were kept from an earlier survey and how many failed, if any."""
    counts = Counter(outcome.state for outcome in result.outcomes)
    names = {TaskState.KEPT: "kept from before", TaskState.FAILED: "failed"}
    parts = [f"{counts[state]} {name}" for state, name in names.items() if counts[state]]
    return f" ({', '.join(parts)})" if parts else ""


def _print(result: SurveyResult, output: Path, seconds: float) -> None:
    frames = sum(row.frames for row in result.rows)
    recorded = sum(row.seconds for row in result.rows)
    console.print(
        f"{len(result.outcomes)} recordings{_states(result)}, {frames} frames,"
        f" {recorded:.0f} s recorded, {seconds:.0f} s taken"
    )
    if result.routes:
        _print_routes(result)
    for row in result.rows:
        for note in (row.state, *row.notes):
            if note != "done":
                console.print(f"{row.name}: {note}", soft_wrap=True)
    if result.left_out:
        console.print(
            f"not in this map, for they were not named: {', '.join(result.left_out)}, of which"
            f" {output / RECORDINGS} holds earlier results; name these recordings too",
            soft_wrap=True,
        )
    if not result.is_earlier_map_kept:
        console.print(f"  {output / REPORT}", soft_wrap=True)


def _print_routes(result: SurveyResult) -> None:
    rows = []
    for name, route in zip(result.names, result.routes, strict=True):
        sigma = float(np.median(route.sigmas))
        rows.append((
            name, f"{route.along[-1]:.1f}", f"{sigma:.3f}", str(len(route.events)),
            ", ".join(route.recordings),
        ))  # fmt: skip
    headings = ("", "length [m]", "median sigma [m]", "events", "recordings")
    print_table("routes", headings, rows, left=(0, 4))
