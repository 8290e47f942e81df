"""`cable-tracker learn`."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.atomic_output import output_file
from cable_tracker.cable.measure.borders.response_table import is_table
from cable_tracker.commands.console.terminal import console, counted, print_left_out, progress_bar
from cable_tracker.commands.options.common import (
    ForceOption,
    OutsideOption,
    PresetOption,
    RateOption,
    SeedOption,
    SkipOption,
    TopicOption,
    TruthOption,
    open_recording,
    refuse_without_effect,
)
from cable_tracker.commands.options.many_runs import seeds_from
from cable_tracker.commands.options.parameters import chosen_parameters
from cable_tracker.errors import ParameterError, RecordingError
from cable_tracker.evaluation.evaluation_sequences import frames_in_all
from cable_tracker.evaluation.learning_sources import (
    FrameCounter,
    LearningPlan,
    describe_origin,
    labelled_recording,
    simulated_dives,
)
from cable_tracker.followed_kinds import CABLE
from cable_tracker.sequences.source_base import ChosenRecording
from cable_tracker.simulation.scenarios import SCENARIOS


def learn(  # noqa: PLR0917
    output: Annotated[Path, typer.Option(help="Table to write, a JSON file.")],
    source: Annotated[
        list[Path] | None, typer.Argument(help="Labelled recordings of any kind.")
    ] = None,
    truth: TruthOption = None,
    scenario: Annotated[
        list[str] | None,
        typer.Option(
            help=f"Learn from simulated dives ({', '.join(SCENARIOS)}), too, or from the worlds"
            " to tune on, also by a pattern such as 'tune_*'; may be given several times."
        ),
    ] = None,
    first_seed: Annotated[
        int | None, typer.Option(help="Seed of the first dive of each.  [default: 0]")
    ] = None,
    seeds: Annotated[
        int | None,
        typer.Option(
            help="Number of dives of each, with the first seed and those that follow it."
            "  [default: 1]"
        ),
    ] = None,
    frames: Annotated[
        int | None,
        typer.Option(help="Number of frames used of each of those dives.  [default: all]", min=1),
    ] = None,
    every: Annotated[int, typer.Option(help="Use every K-th frame only.", min=1)] = 1,
    harder: Annotated[
        int,
        typer.Option(
            help="Count each frame also so many times with the cable faded, the picture blurred"
            " and in noise.",
            min=0,
            max=100,
        ),
    ] = 1,
    preset_name: PresetOption = None,
    params: Annotated[
        Path | None,
        typer.Option(help="YAML file with the parameters that the table will be used with."),
    ] = None,
    seed: SeedOption = None,
    unlabelled_is_empty: Annotated[
        bool,
        typer.Option(
            "--unlabelled-is-empty",
            help="Frames of the recordings without a label show no cable, and count as background;"
            " else they are passed over.",
        ),
    ] = False,
    force: ForceOption = False,
    topic: TopicOption = None,
    rate: RateOption = None,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
) -> None:
    """Learn response tables from labelled recordings.

    They hold how likely a response of the border filter is on a cable and beside it.

    The tracker uses them with the parameter `response_table`. Its parameters `working_width` and
    `filter_sigma` should be those that the tables were learnt with. The same command writes the
    same file. Of a recording that breaks off, the frames before that count.
    """
    paths, scenarios = source or [], list(dict.fromkeys(scenario or []))
    _check_sources(paths, truth, scenarios)
    if not paths:
        of_recordings = {"--unlabelled-is-empty": unlabelled_is_empty}
        refuse_without_effect(of_recordings, "can only do something for a recording")
    if not scenarios:
        of_dives = {"--first-seed": first_seed, "--seeds": seeds, "--frames": frames}
        refuse_without_effect(of_dives, "can only do something with --scenario")
    numbers = seeds_from(1 if seeds is None else seeds, first_seed or 0)
    _, parameters = chosen_parameters(CABLE, preset_name, params, {}, seed)
    plan = LearningPlan(every, harder, frames, skip_bad_frames, unlabelled_is_empty)
    sequences, left_out = simulated_dives(scenarios, numbers, plan.limit)
    print_left_out(left_out)
    counter = FrameCounter(parameters, plan)
    damages: list[RecordingError] = []
    with ExitStack() as stack:
        for path in paths:
            chosen = ChosenRecording(path, topic, rate, truth, skip_bad_frames, allow_outside)
            recording = stack.enter_context(open_recording(chosen))
            sequences.append(labelled_recording(recording, plan))
        file = stack.enter_context(output_file(output, is_table, overwrite=force))
        total = frames_in_all(sequence.frame_count for sequence in sequences)
        progress = stack.enter_context(progress_bar("learning", total))
        for sequence in sequences:
            try:
                counter.count(sequence, counted(sequence.frames(), progress))
            except RecordingError as damage:
                damages.append(damage)
        if damages and not counter.counts.frames:
            raise damages[0]
        table = counter.counts.table(
            describe_origin(scenarios, numbers, paths, truth, plan, left_out=left_out)
        )
        table.save(file)
    console.print(
        f"{counter.describe()}, {counter.counts.border_points} points on borders,"
        f" {counter.counts.background_points} elsewhere",
        soft_wrap=True,
    )
    console.print(f"learnt from {table.source}: {output}", soft_wrap=True)
    if damages:
        raise RecordingError("; ".join(map(str, damages)))


def _check_sources(paths: Sequence[Path], truth: Path | None, scenarios: Sequence[str]) -> None:
    if not (paths or scenarios):
        raise ParameterError(
            "there is nothing to learn from; name a labelled recording, or give --scenario"
        )
    if truth is not None and len(paths) != 1:
        raise ParameterError(
            f"--truth labels a single recording, not {len(paths)}; learn from sequence files"
            " instead, which name their pictures"
        )
