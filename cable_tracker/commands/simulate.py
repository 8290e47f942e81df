"""`cable-tracker simulate`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.commands.console.ros_part import need_ros
from cable_tracker.commands.console.terminal import advance_to, console, counted, progress_bar
from cable_tracker.commands.options.common import (
    ForceOption,
    parse_size,
    print_notes,
    refuse_without_effect,
)
from cable_tracker.errors import ParameterError
from cable_tracker.sequences.bags.bag_writer import StorageFormat, kept_notes
from cable_tracker.sequences.bags.convert import write_bag
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.labels.target_writer import write_target_bag, write_target_pictures
from cable_tracker.sequences.pictures.image_writer import write_sequence
from cable_tracker.simulation.dive import Dive
from cable_tracker.simulation.instruments.dive_ticks import dive_ticks
from cable_tracker.simulation.instruments.instrument_writer import write_ticks
from cable_tracker.simulation.instruments.survey_dive import (
    SurveyDiveSettings,
    usual_survey,
    write_survey_bag,
)
from cable_tracker.simulation.rendering.camera import NO_DISTORTION, Distortion
from cable_tracker.simulation.scenario_dive import (
    SimulationSettings,
    scenario_dive,
    simulate,
    simulate_scenario,
    simulated_dive,
)
from cable_tracker.simulation.scenarios import SCENARIO_RATE, SCENARIOS, find_scenario
from cable_tracker.simulation.settings import check_frames, check_seed, check_size
from cable_tracker.simulation.targets.scenarios import TARGET_SCENARIOS
from cable_tracker.simulation.targets.sequence import (
    TargetFrame,
    find_target_scenario,
    labelled_frames,
    simulate_target,
)
from cable_tracker.simulation.worlds.catalogue import WORLDS
from cable_tracker.simulation.worlds.world_dive import simulate_world

FRAMES, RATE, CLUTTER = 300, 25.0, 0.5
"""Number of frames, frame rate [1/s] and clutter that are simulated by default."""

FILES = ("--format", "--storage", "--force")

OPTIONS_OF = {
    "": ("--frames", "--rate", "--clutter", "--distortion", *FILES),
    "--live": ("--rate",),
    "--target": ("--frames", "--rate", *FILES),
    "--survey": ("--rate", "--cable-seed", "--storage", "--force"),
    "--scenario": FILES,
}
"""Options that have an effect, by the option that says what is simulated."""


class SimulationFormat(str, Enum):
    """Format that `simulate` writes."""

    BAG = "bag"
    SEQUENCE = "sequence"


def simulate_command(  # noqa: PLR0917
    output: Annotated[
        Path | None, typer.Argument(help="Folder to write; none with --live.")
    ] = None,
    output_format: Annotated[
        SimulationFormat | None,
        typer.Option("--format", help="A ROS 2 bag, or PNGs with a sequence file.  [default: bag]"),
    ] = None,
    frames: Annotated[
        int | None, typer.Option(help=f"Number of frames.  [default: {FRAMES}]")
    ] = None,
    rate: Annotated[
        float | None, typer.Option(help=f"Frames per second.  [default: {RATE:g}]")
    ] = None,
    size: Annotated[str, typer.Option(help="Width and height in px.")] = "320x240",
    clutter: Annotated[
        float | None,
        typer.Option(
            help="Amount of growth, burial and distracting objects, 0 to 1."
            f"  [default: {CLUTTER:g}]"
        ),
    ] = None,
    distortion: Annotated[
        str | None,
        typer.Option(
            metavar="K1,K2,P1,P2,K3",
            help="Distortion of the lens by the model plumb_bob; a bag has it in its camera_info."
            "  [default: none]",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed: the same one gives the same frames.")] = 0,
    scenario: Annotated[
        str | None,
        typer.Option(
            help=f"A scenario of the evaluation instead ({', '.join(SCENARIOS)}), or a world"
            " (tune_* or report_*, see docs/simulation.md); it has its own length, rate and"
            " clutter."
        ),
    ] = None,
    target: Annotated[
        str | None,
        typer.Option(
            help="A target with an outline instead of a cable, with a box in every frame:"
            f" {', '.join(TARGET_SCENARIOS)}."
        ),
    ] = None,
    photographs: Annotated[
        Path | None,
        typer.Option(help="Folder of photographs to cover the bottom of a scenario with."),
    ] = None,
    survey: Annotated[
        float | None,
        typer.Option(
            help="Length of cable [m] that a vehicle with all its instruments inspects instead: the"
            " bag holds odometry, imu, altitude, fixes and mounting too."
        ),
    ] = None,
    cable_seed: Annotated[
        int | None,
        typer.Option(
            help="With --survey: seed of the cable, the same for several dives.  [default: 0]"
        ),
    ] = None,
    storage: Annotated[
        StorageFormat | None, typer.Option(help="Format of the bag.  [default: mcap]")
    ] = None,
    force: ForceOption = False,
    live: Annotated[
        bool,
        typer.Option(
            "--live", help="Run the ROS node `simulator` instead: a vehicle that obeys `cmd_vel`."
        ),
    ] = False,
) -> None:
    """Simulate a cable or a target, with exact ground truth."""
    image_size = parse_size(size)
    kind = _only_kind(live, target, survey, scenario)
    _check_photographs(kind, photographs)
    options = {
        "--frames": frames, "--rate": rate, "--clutter": clutter, "--distortion": distortion,
        "--cable-seed": cable_seed, "--format": output_format, "--storage": storage,
        "--force": force,
    }  # fmt: skip
    _check_effects(kind, options)
    frames = FRAMES if frames is None else frames
    rate = RATE if rate is None else rate
    if live:
        raise typer.Exit(_run_live(output, seed, image_size, rate))
    if output is None:
        raise ParameterError("output: name a folder to write, or give --live")
    destination = _Destination(
        output, output_format or SimulationFormat.BAG, storage or StorageFormat.MCAP, force
    )
    if target is not None:
        _check_target(target, frames, rate, image_size, seed)
        simulated = simulate_target(target, seed, frames, rate=rate, size=image_size)
        _write_target(destination, simulated, frames)
    elif survey is not None:
        usual = usual_survey(survey, seed, cable_seed or 0)
        _write_survey(destination, replace(usual, rate=rate, image_size=image_size))
    elif scenario is not None:
        _write_cable(destination, _scenario_frames(scenario, seed, image_size, photographs), seed)
    else:
        overgrown = CLUTTER if clutter is None else clutter
        lens = NO_DISTORTION if distortion is None else _parse_distortion(distortion)
        settings = SimulationSettings(
            frames, rate, image_size, overgrown, distortion=lens, seed=seed
        )
        _write_cable(destination, _own_frames(settings), seed)


def _parse_distortion(text: str) -> Distortion:
    """Read the coefficients of a lens, such as -0.15,0.02,0,0,0."""
    try:
        k1, k2, p1, p2, k3 = (float(each) for each in text.split(","))
    except ValueError:
        raise ParameterError(
            f"distortion: {text!r} is not of the form K1,K2,P1,P2,K3; give five numbers with "
            "commas between them, such as -0.15,0.02,0,0,0"
        ) from None
    return k1, k2, p1, p2, k3


def _only_kind(live: bool, target: str | None, survey: float | None, scenario: str | None) -> str:
    """Return the option that says what is simulated; empty: a cable of the user's own settings."""
    kinds = {
        "--live": live or None,
        "--target": target,
        "--survey": survey,
        "--scenario": scenario,
    }
    chosen = [name for name, value in kinds.items() if value is not None]
    if len(chosen) > 1:
        raise ParameterError(f"{' and '.join(chosen)}: give one of these")
    return chosen[0] if chosen else ""


def _check_effects(kind: str, options: Mapping[str, object]) -> None:
    """Refuse options, by name, that have no effect on a kind of simulation or its format."""
    unused = {name: value for name, value in options.items() if name not in OPTIONS_OF[kind]}
    refuse_without_effect(
        unused, f"can do nothing with {kind}" if kind else "can do nothing without --survey"
    )
    if options["--format"] is SimulationFormat.SEQUENCE:
        refuse_without_effect(
            {"--storage": options["--storage"]}, "can do nothing with --format sequence"
        )


def _check_photographs(kind: str, photographs: Path | None) -> None:
    """Refuse photographs for anything but the bottom of a scenario."""
    if photographs is None or kind == "--scenario":
        return
    if kind:
        raise ParameterError(
            f"--photographs covers the bottom of a scenario, not of {kind}; leave it out"
        )
    raise ParameterError("photographs cover the bottom of a scenario; name one with --scenario")


@dataclass(frozen=True, slots=True)
class _Destination:
    """Where and in which format the frames are written.

    Attributes
    ----------
    folder : Path
        Folder of the bag or of the pictures.
    kind : SimulationFormat
        Format that is written.
    storage : StorageFormat
        Format of the bag.
    force : bool
        Replace what lies there already.
    """

    folder: Path
    kind: SimulationFormat
    storage: StorageFormat
    force: bool


@dataclass(frozen=True, slots=True)
class _CableFrames:
    """Frames of a simulated cable.

    Attributes
    ----------
    count : int
        Number of frames.
    frames : iterator of Frame
        Frames with their ground truth.
    dive : (Dive, float) or None
        Simulated dive and frame rate [Hz], for the instruments of a bag; None: without instruments.
    """

    count: int
    frames: Iterator[Frame]
    dive: tuple[Dive, float] | None


def _scenario_frames(
    name: str, seed: int, image_size: tuple[int, int], photographs: Path | None
) -> _CableFrames:
    """Return the frames of a scenario or a world of the evaluation."""
    if name in WORLDS:
        if photographs is not None:
            raise ParameterError(
                f"photographs: the world {name} has its own bottom; leave --photographs out"
            )
        frames = (each.frame for each in simulate_world(name, seed, image_size))
        return _CableFrames(WORLDS[name].frame_count, frames, None)
    count = find_scenario(name).frame_count
    simulated = simulate_scenario(name, seed, image_size, photographs=photographs)
    dive = scenario_dive(name, seed, image_size)
    return _CableFrames(count, (each.frame for each in simulated), (dive, SCENARIO_RATE))


def _own_frames(settings: SimulationSettings) -> _CableFrames:
    """Return the frames that the user's own settings describe."""
    dive = simulated_dive(settings)
    return _CableFrames(settings.frame_count, simulate(settings), (dive, settings.rate))


def _write_cable(destination: _Destination, cable: _CableFrames, seed: int) -> None:
    """Write the frames of a cable, with their truth."""
    folder, storage, force = destination.folder, destination.storage, destination.force
    kept = kept_notes(folder) if force and cable.dive is None else []
    with progress_bar("simulating", cable.count) as progress:
        frames = counted(cable.frames, progress)
        if destination.kind is SimulationFormat.SEQUENCE:
            count = write_sequence(folder, frames, overwrite=force)
        elif cable.dive is None:
            count = write_bag(folder, frames, storage=storage, overwrite=force).count
        else:
            dive, rate = cable.dive
            ticks, height = dive_ticks(frames, dive, rate, seed), dive.tube.height
            count = write_ticks(
                folder, ticks, dive.camera, height, storage=storage, overwrite=force
            ).frames
    print_notes(folder, kept)
    console.print(f"{count} frames: {folder}", soft_wrap=True)


def _check_target(
    scenario: str, frames: int, rate: float, image_size: tuple[int, int], seed: int
) -> None:
    """Refuse values with which no target can be simulated."""
    find_target_scenario(scenario)
    check_size(image_size)
    check_seed(seed)
    check_frames(frames, rate)


def _write_target(destination: _Destination, simulated: Iterable[TargetFrame], frames: int) -> None:
    """Write the frames of a target's scenario, with its boxes."""
    folder, force = destination.folder, destination.force
    kept = kept_notes(folder) if force else []
    with progress_bar("simulating", frames) as progress:
        labelled = labelled_frames(counted(simulated, progress))
        if destination.kind is SimulationFormat.BAG:
            count = write_target_bag(folder, labelled, storage=destination.storage, overwrite=force)
        else:
            count = write_target_pictures(folder, labelled, overwrite=force)
    print_notes(folder, kept)
    console.print(f"{count} frames: {folder}", soft_wrap=True)


def _write_survey(destination: _Destination, settings: SurveyDiveSettings) -> None:
    """Let a vehicle inspect a cable, and write everything that its bag holds."""
    with progress_bar("simulating, in m", round(settings.length)) as progress:
        dive = write_survey_bag(
            destination.folder,
            settings,
            storage=destination.storage,
            overwrite=destination.force,
            advance=lambda way: advance_to(progress, way),
        )
    console.print(
        f"{dive.frames} frames, {dive.seconds:.0f} s: {destination.folder}", soft_wrap=True
    )


def _run_live(output: Path | None, seed: int, image_size: tuple[int, int], rate: float) -> int:
    """Run the simulator node in this process until its cable is at its end; return its code."""
    if output is not None:
        raise ParameterError(f"output: --live publishes and writes nothing; leave {output} out")
    entry = need_ros("entry")
    width, height = image_size
    values = {"seed": seed, "image_width": width, "image_height": height, "rate": rate}
    given = [word for name, value in values.items() for word in ("-p", f"{name}:={value}")]
    return int(entry.run("simulator", ["simulator", "--ros-args", *given]))
