"""`cable-tracker loop`."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from cable_tracker.cable.parameter_files import read_parameter_file
from cable_tracker.commands.options import ForceOption, PresetName
from cable_tracker.commands.ros_part import need_ros
from cable_tracker.commands.simulate import parse_size
from cable_tracker.commands.terminal import console, progress_bar
from cable_tracker.evaluation.closed_loop import GOAL, LoopSummary
from cable_tracker.simulation.live_world import LiveSettings
from cable_tracker.trackers import PROPOSERS


def loop(  # noqa: PLR0917
    seed: Annotated[
        int, typer.Option(help="Seed of world, instruments and filter: the same, the same files.")
    ] = 0,
    length: Annotated[float, typer.Option(help="Of the cable [m].")] = 100.0,
    buried: Annotated[
        float | None,
        typer.Option(help="Length of the stretch under sand [m].  [default: 5, if there is room]"),
    ] = None,
    current: Annotated[float, typer.Option(help="Speed of the water [m/s].")] = 0.1,
    altitude: Annotated[float, typer.Option(help="That the vehicle keeps [m].")] = 2.0,
    speed: Annotated[float, typer.Option(help="Of the vehicle through the water [m/s].")] = 0.5,
    size: Annotated[str, typer.Option(help="Of the images, in px.")] = "320x240",
    rate: Annotated[float, typer.Option(help="Frames per second.")] = 12.5,
    preset_name: Annotated[
        PresetName | None,
        typer.Option("--preset", help="Values of the filter to start from.  [default: default]"),
    ] = None,
    detector: Annotated[
        str | None,
        typer.Option(help=f"Detector that the filter asks: {', '.join(PROPOSERS)}."),
    ] = None,
    params: Annotated[
        Path | None, typer.Option(help="YAML file with parameters of the tracker.")
    ] = None,
    realtime: Annotated[
        bool,
        typer.Option("--realtime", help="Run freely in real time, instead of in lockstep."),
    ] = False,
    output: Annotated[
        Path | None, typer.Option(help="Folder for the results.  [default: loop_SEED]")
    ] = None,
    force: ForceOption = False,
) -> None:
    """Let a simulated vehicle follow a cable by the tracker's word, over ROS.

    Simulator, tracker and the example of a controller run as processes of their own. Table, plots
    and a video go into one folder.
    """
    ros = need_ros("loop")
    sand = min(5.0, length / 4) if buried is None else buried
    request = ros.LoopRequest(
        world=LiveSettings(seed, length, sand, altitude, current, parse_size(size), rate),
        tracker={
            **(read_parameter_file(params) if params is not None else {}),
            **({"preset": preset_name.value} if preset_name is not None else {}),
            "seed": seed,
            **({"detector": detector} if detector is not None else {}),
        },
        speed=speed,
        realtime=realtime,
    )
    folder = output if output is not None else Path(f"loop_{seed}")
    with progress_bar("following [m]", round(length)) as progress:
        task = progress.task_ids[0]
        summary = ros.run_loop(
            request,
            folder,
            overwrite=force,
            advance=lambda way: progress.update(task, completed=max(0, round(way))),
        )
    _print(summary)
    for name in (ros.TABLE, ros.SUMMARY, ros.WAY, ros.ERRORS, ros.VIDEO):
        console.print(f"  {folder / name}", soft_wrap=True)


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
    "measured": "frames with cross_track",
    "wrong": "frames with that of no cable",
    "losses": "times lost",
    "longest_loss": "longest loss [s]",
    "found_again": "found again after the sand",
    "lost_for_good": "lost for good",
}


def _print(summary: LoopSummary) -> None:
    table = Table(title="closed loop")
    table.add_column("")
    table.add_column("", justify="right")
    for field in fields(LoopSummary):
        table.add_row(LABELS[field.name], _cell(field.name, getattr(summary, field.name)))
    console.print(table)
    verdict = "lost for good" if summary.lost_for_good else "not lost for good"
    goal = "within" if summary.is_within_goal else "not within"
    console.print(f"The cable was {verdict}; the run is {goal} the goal of {GOAL:g} m RMS.")


def _cell(name: str, value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if name in {"measured", "wrong"}:
        return f"{value:.1%}"
    return f"{value:.3g}" if isinstance(value, float) else str(value)
