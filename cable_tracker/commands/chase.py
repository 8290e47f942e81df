"""`cable-tracker chase`."""

from __future__ import annotations

import math
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.commands.console.ros_part import need_ros
from cable_tracker.commands.console.terminal import advance, print_facts, print_files, progress_bar
from cable_tracker.commands.options.common import ForceOption, TargetPresetName
from cable_tracker.simulation.targets.chase import ChaseSettings

SHARES = {"kept", "claimed_in_view", "claimed_while_absent", "range_error", "within_two_sigmas"}


def chase(  # noqa: PLR0917
    output: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("chase"),
    duration: Annotated[float, typer.Option(min=5.0, max=1e5, help="Simulated time [s].")] = 300.0,
    distance: Annotated[
        float, typer.Option(min=0.5, max=50.0, help="Distance to keep behind the target [m].")
    ] = 2.5,
    hidden_for: Annotated[
        float,
        typer.Option(
            min=0.0, max=40.0, help="Time for which silt hides the target every 50 s [s]."
        ),
    ] = 6.0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the world.")] = 0,
    preset_name: Annotated[
        TargetPresetName, typer.Option("--preset", help="Preset of the target tracker.")
    ] = TargetPresetName["default"],
    force: ForceOption = False,
) -> None:
    """Let a simulated vehicle follow a moving target over DDS.

    Clouds of silt hide the target now and then. Simulator, target tracker and follower run in
    lockstep, as fast as the machine can. Needs ROS 2.
    """
    rigs = need_ros("rigs.closed_loop.chase")
    world = ChaseSettings(seed=seed, duration=duration, hidden_for=hidden_for)
    request = rigs.ChaseRequest(
        world=world,
        preset=preset_name.value,
        distance=distance,
    )
    with progress_bar("following", math.ceil(duration * world.rate) + 1) as progress:
        summary = rigs.run_chase(
            request, output, overwrite=force, advance=partial(advance, progress)
        )
    print_facts(
        "chase",
        (
            (name.replace("_", " "), f"{value:.1%}" if name in SHARES else f"{value:.4g}")
            for name, value in asdict(summary).items()
        ),
    )
    print_files(output, rigs.file_names())
