"""`cable-tracker dev soak`."""

from __future__ import annotations

from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cable_tracker.atomic_output import output_file
from cable_tracker.commands.console.machine import machine, typed_command
from cable_tracker.commands.console.ros_part import need_ros
from cable_tracker.commands.console.terminal import advance_to, console, print_table, progress_bar
from cable_tracker.commands.options.common import ForceOption, parse_size
from cable_tracker.sequences.frame import Frame
from cable_tracker.simulation.scenario_dive import SimulationSettings, simulate
from cable_tracker.simulation.settings import check_size
from cable_tracker.simulation.targets.sequence import labelled_frames, simulate_target

if TYPE_CHECKING:
    from cable_tracker.ros.rigs.soak.record import SoakRecord

EXIT_BROKEN_PROMISE = 1
FRAMES = 100
MARK = b'"broken_promises"'
"""Stands in every report."""

PROGRESS_STEPS = 1000


def soak(  # noqa: PLR0917
    minutes: Annotated[float, typer.Option(help="Duration [min].", min=0.0)] = 10.0,
    seed: Annotated[int, typer.Option(help="Seed of the faults.", min=0)] = 0,
    faults: Annotated[
        float, typer.Option(help="Share of the frames with a fault.", min=0.0, max=1.0)
    ] = 0.02,
    frames: Annotated[
        int, typer.Option(help="Number of answered frames after which it ends; 0: never.", min=0)
    ] = 0,
    target: Annotated[
        bool, typer.Option("--target", help="Soak the tracker of targets, in colour.")
    ] = False,
    preset_name: Annotated[
        str, typer.Option("--preset", help="Preset of the tracker.")
    ] = "default",
    particles: Annotated[int, typer.Option(help="Particles of the tracker.", min=10)] = 500,
    size: Annotated[str, typer.Option(help="Width and height of the frames in px.")] = "320x240",
    output: Annotated[Path, typer.Option(help="Report to write, a JSON file.")] = Path("soak.json"),
    force: ForceOption = False,
) -> None:
    """Feed a tracker for a long time, with faults.

    Shows whether it keeps its promises. Frames go in lockstep and at full rate. Bad frames of every
    class, jumping stamps, a stopped input, overload, parameter storms, viewers, cameras of other
    quality of service; tracker and replay are killed and started again. The report holds faults,
    recoveries, latency and memory over time. Exit code 1 if a promise was broken.
    """
    module = need_ros("rigs.soak.soak")
    settings = module.SoakSettings(
        minutes=minutes,
        seed=seed,
        fault_share=faults,
        frames=frames,
        preset=preset_name,
        particles=particles,
        node="target_tracker" if target else "tracker",
    )
    module.check_settings(settings)
    with output_file(output, _is_report, overwrite=force) as file:
        pictures = _pictures(parse_size(size), seed, target=target)
        with progress_bar("soaking", PROGRESS_STEPS) as progress:
            record = module.run_soak(
                pictures,
                settings,
                lambda share: advance_to(progress, share * PROGRESS_STEPS),
            )
        facts = {"command": typed_command(), "machine": machine(), **asdict(settings)}
        file.write_text(record.as_json(facts), encoding="utf-8")
    _print(record)
    console.print(f"  {output}", soft_wrap=True)
    if record.breaches:
        raise typer.Exit(EXIT_BROKEN_PROMISE)


def _pictures(size: tuple[int, int], seed: int, *, target: bool) -> list[Frame]:
    """Return the frames for the tracker: a cable in grey, or a target in colour."""
    if not target:
        settings = SimulationSettings(frame_count=FRAMES, image_size=size, seed=seed)
        return list(islice(simulate(settings), FRAMES))
    check_size(size)
    simulated = simulate_target("leaving", seed, FRAMES, size=size)
    return [frame for frame, _ in labelled_frames(simulated)]


def _is_report(path: Path) -> bool:
    return path.is_file() and MARK in path.read_bytes()


def _print(record: SoakRecord) -> None:
    faults = (
        (name, str(count), str(record.recoveries[name]))
        for name, count in sorted(record.faults.items())
    )
    print_table("faults", ("class", "injected", "recovered"), faults, left=(0,))
    windows = []
    for each in record.latency_windows():
        times = (f"{each[name]:.1f}" for name in ("median", "percentile_99", "longest"))
        windows.append((f"{each['minutes']:g}", str(each["frames"]), *times))
    headings = ("minute", "frames", "median", "99 %", "longest")
    print_table("time to the answer in lockstep [ms]", headings, windows)
    console.print(
        f"{record.sent} frames sent, {record.answered} answered;"
        f" {record.faults.total()} faults, {record.recoveries.total()} recoveries;"
        f" {record.messages.total()} messages looked at;"
        f" memory grew by {record.growth():.1f} MB at most after the warm-up",
        soft_wrap=True,
    )
    for breach in record.breaches:
        console.print(f"broken promise: {breach}", style="bold red", soft_wrap=True)
    if not record.breaches:
        console.print("all promises kept")
