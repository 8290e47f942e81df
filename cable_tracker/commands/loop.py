"""`cable-tracker loop`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any

import typer

from cable_tracker.cable.parameters.parameters import PARAMETERS_BY_NAME
from cable_tracker.commands.console.ros_part import need_ros
from cable_tracker.commands.console.terminal import (
    advance_to,
    console,
    print_facts,
    print_files,
    progress_bar,
)
from cable_tracker.commands.many_runs.loops import (
    MOST_WORKERS,
    LoopTask,
    follow_several,
    format_measure,
)
from cable_tracker.commands.options.common import ForceOption, parse_size, refuse_without_effect
from cable_tracker.commands.options.many_runs import (
    MEMORY,
    DashboardOption,
    MemoryOption,
    ResumeOption,
    SchedulerOption,
    chosen_cluster,
    seeds_from,
)
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.loop_table import GOAL, LoopSummary
from cable_tracker.evaluation.methods import BASELINES, METHODS
from cable_tracker.simulation.live_world import LiveSettings
from cable_tracker.tracking.parameter_files import read_parameter_file
from cable_tracker.tracking.parameter_table import check_name

DETECTORS = PARAMETERS_BY_NAME["detector"].choices


def loop(  # noqa: PLR0917
    seed: Annotated[
        int, typer.Option(help="Seed of world, instruments and filter: the same, the same files.")
    ] = 0,
    seeds: Annotated[
        int, typer.Option(help="Number of runs, with the seed and those that follow it.")
    ] = 1,
    method: Annotated[
        list[str] | None,
        typer.Option(
            help=f"Tracking method: {' | '.join(METHODS)}; may be given several times."
            "  [default: default]"
        ),
    ] = None,
    length: Annotated[float, typer.Option(help="Length of the cable [m].")] = 100.0,
    buried: Annotated[
        float | None,
        typer.Option(help="Length of the stretch under sand [m].  [default: 5, if there is room]"),
    ] = None,
    current: Annotated[float, typer.Option(help="Speed of the water current [m/s].")] = 0.1,
    altitude: Annotated[float, typer.Option(help="Altitude that the vehicle keeps [m].")] = 2.0,
    speed: Annotated[
        float, typer.Option(help="Speed of the vehicle through the water [m/s].")
    ] = 0.5,
    size: Annotated[str, typer.Option(help="Width and height of the images in px.")] = "320x240",
    rate: Annotated[float, typer.Option(help="Frames per second.")] = 12.5,
    standstill: Annotated[
        float,
        typer.Option(help="Time of commands to stand still after which a run ends [s]."),
    ] = 15.0,
    detector: Annotated[
        str | None,
        typer.Option(help=f"Detector that the filter asks: {', '.join(DETECTORS)}."),
    ] = None,
    params: Annotated[
        Path | None, typer.Option(help="YAML file with parameters of the tracker.")
    ] = None,
    realtime: Annotated[
        bool,
        typer.Option("--realtime", help="Run freely in real time, instead of in lockstep."),
    ] = False,
    video: Annotated[
        bool | None,
        typer.Option("--video/--no-video", help="Write a video.  [default: of a single run]"),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(help="Number of runs at once, each in four processes.  [default: 1]"),
    ] = None,
    scheduler: SchedulerOption = None,
    memory: MemoryOption = MEMORY,
    dashboard: DashboardOption = False,
    resume: ResumeOption = False,
    output: Annotated[
        Path | None,
        typer.Option(help="Folder for the results.  [default: loop_SEED; of several: loop_runs]"),
    ] = None,
    force: ForceOption = False,
) -> None:
    """Let a simulated vehicle follow a cable, over ROS.

    Simulator, tracker and the example of a controller run as processes of their own. Table, plots
    and a video go into one folder. With several seeds or methods each run has a folder of its own
    beside the tables of all; a run that fails does not end the others.
    """
    methods = tuple(dict.fromkeys(method or ("default",)))
    _check_methods(methods, is_tuned=params is not None or detector is not None)
    chosen = seeds_from(seeds, seed) if seed >= 0 else (seed,)
    several = len(chosen) * len(methods) > 1
    if not several:
        of_several = {
            "--workers": workers if workers != 1 else None,
            "--scheduler": scheduler,
            "--dashboard": dashboard,
            "--resume": resume,
        }
        refuse_without_effect(of_several, "can only do something for several runs")
    ros = need_ros("rigs.closed_loop.loop")
    sand = min(5.0, length / 4) if buried is None else buried
    width, height = parse_size(size)
    request = ros.LoopRequest(
        world=LiveSettings(
            seed=seed,
            length=length,
            buried=sand,
            altitude=altitude,
            current=current,
            image_width=width,
            image_height=height,
            rate=rate,
        ),
        method=methods[0],
        tracker=_tracker_values(params, seed, detector),
        speed=speed,
        realtime=realtime,
        standstill=standstill,
        with_video=video if video is not None else not several,
    )
    if not several:
        _run_one(ros, request, output if output is not None else Path(f"loop_{seed}"), force)
        return
    workers = 1 if workers is None else workers
    if not 1 <= workers <= MOST_WORKERS:
        raise ParameterError(f"workers is {workers}: give 1 to {MOST_WORKERS}")
    cluster = chosen_cluster(workers, scheduler, memory, dashboard)
    arguments = _shared_arguments(request, detector, params)
    files = _files_of(params, scheduler)
    tasks = [LoopTask(method, each, arguments, files) for method in methods for each in chosen]
    path = output if output is not None else Path("loop_runs")
    follow_several(tasks, path, cluster, force=force, resume=resume)


def _tracker_values(params: Path | None, seed: int, detector: str | None) -> dict[str, object]:
    """Return the parameters that the user gives the tracker."""
    values = read_parameter_file(params) if params is not None else {}
    return values | {"seed": seed} | ({"detector": detector} if detector is not None else {})


def _files_of(params: Path | None, scheduler: str | None) -> tuple[Path, ...]:
    """Return a parameter file and the response table that it names.

    Raises
    ------
    ParameterError
        Each worker of a scheduler would look for the table in the folder where it was started.
    """
    if params is None:
        return ()
    name = str(read_parameter_file(params).get("response_table") or "")
    if scheduler is not None and name and not Path(name).is_absolute():
        raise ParameterError(
            f"response_table: {params} names {name}, which workers elsewhere would not find; give"
            f" its whole path, {Path(name).absolute()}"
        )
    files = [params, Path(name)] if name else [params]
    return tuple(file.absolute() for file in files)


def _shared_arguments(
    request: Any,  # noqa: ANN401  A class of the ROS part.
    detector: str | None,
    params: Path | None,
) -> tuple[str, ...]:
    """Return the options of `cable-tracker loop` that each run of several is started with."""
    world = request.world
    return (
        f"--length={world.length}", f"--buried={world.buried}", f"--current={world.current}",
        f"--altitude={world.altitude}", f"--speed={request.speed}",
        f"--size={world.image_width}x{world.image_height}", f"--rate={world.rate}",
        f"--standstill={request.standstill}",
        "--video" if request.with_video else "--no-video",
        *([f"--detector={detector}"] if detector is not None else []),
        *([f"--params={params.resolve()}"] if params is not None else []),
        *(["--realtime"] if request.realtime else []),
    )  # fmt: skip


def _check_methods(methods: Sequence[str], *, is_tuned: bool) -> None:
    for name in methods:
        check_name("method", name, METHODS)
        if is_tuned and name in BASELINES:
            raise ParameterError(
                f"--params and --detector have no effect on {name}; leave them out"
            )


def _run_one(ros: ModuleType, request: Any, folder: Path, force: bool) -> None:  # noqa: ANN401
    with progress_bar("following [m]", round(request.world.length)) as progress:
        summary = ros.run_loop(
            request,
            folder,
            overwrite=force,
            advance=lambda way: advance_to(progress, way),
        )
    _print(summary)
    print_files(folder, ros.file_names(request))


LABELS = {
    "seed": "seed",
    "frames": "frames",
    "seconds": "time [s]",
    "way": "way along the cable [m]",
    "reached_end": "end reached",
    "rms": "lateral error, RMS [m]",
    "percentile_95": "its 95th percentile [m]",
    "most": "its maximum [m]",
    "rms_in_sight": "its RMS with the cable in sight [m]",
    "rms_offset": "cross_track, RMS error of y [m]",
    "rms_heading": "cross_track, RMS error of yaw [deg]",
    "answered": "frames answered",
    "measured": "frames with cross_track",
    "wrong": "frames with that of no cable",
    "losses": "times lost",
    "longest_loss": "longest loss [s]",
    "found_again": "found again after the sand",
    "lost_for_good": "lost for good",
}

MOST_DIGITS = 6
"""An RMS that cannot be told from the goal by so many decimals is as good as equal to it."""


def _print(summary: LoopSummary) -> None:
    facts = asdict(summary).items()
    print_facts(
        "closed loop", ((LABELS[name], format_measure(name, value)) for name, value in facts)
    )
    console.print(verdict_on(summary))


def verdict_on(summary: LoopSummary) -> str:
    """Describe how a run ended, with an RMS that can be told from the goal."""
    end = "lost for good" if summary.lost_for_good else "not lost for good"
    goal = "within" if summary.is_within_goal else "not within"
    digits = 3
    while digits < MOST_DIGITS and f"{summary.rms:.{digits}f}" == f"{GOAL:.{digits}f}":
        digits += 1
    return (
        f"The cable was {end}; the run is {goal} the goal:"
        f" RMS {summary.rms:.{digits}f} m, goal {GOAL:g} m."
    )
