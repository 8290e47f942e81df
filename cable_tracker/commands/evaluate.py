"""`cable-tracker evaluate`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, TypeVar

import typer

from cable_tracker.commands.console.terminal import print_left_out
from cable_tracker.commands.many_runs.cables import evaluate_cables, tuned_filters
from cable_tracker.commands.many_runs.targets import (
    chosen_methods,
    evaluate_targets,
    simulated_targets,
    tuned_targets,
)
from cable_tracker.commands.options.common import (
    ForceOption,
    OutsideOption,
    RateOption,
    SkipOption,
    TopicOption,
    TruthOption,
    refuse_without_effect,
)
from cable_tracker.commands.options.many_runs import (
    MEMORY,
    DashboardOption,
    FirstSeedOption,
    MemoryOption,
    ResumeOption,
    SchedulerOption,
    SeedsOption,
    WorkersOption,
    chosen_cluster,
    seeds_from,
)
from cable_tracker.commands.options.parameters import ValueOption
from cable_tracker.evaluation.evaluation_sequences import (
    EvaluationSequence,
    LabelledRecording,
    RecordingSequence,
    available_sequences,
)
from cable_tracker.evaluation.methods import METHODS, ConfiguredFilter
from cable_tracker.evaluation.runs import Campaign, Start
from cable_tracker.evaluation.targets.comparison import TargetCampaign
from cable_tracker.evaluation.targets.target_sequences import RecordedTarget, TargetSequence

Recording = TypeVar("Recording", bound=LabelledRecording)


def evaluate(  # noqa: PLR0917
    method: Annotated[
        list[str] | None,
        typer.Option(
            help=f"{' | '.join(METHODS)}; may be given several times. With --targets: a preset, a"
            " tracker of OpenCV, or `grey` and one of these."
            "  [default: all; with parameters of your own: default]"
        ),
    ] = None,
    params: Annotated[
        list[Path] | None,
        typer.Option(
            help="Judge the tracker with the parameters of this YAML file too, under the file's"
            " name; may be given several times."
        ),
    ] = None,
    param: ValueOption = None,
    table: Annotated[
        Path | None,
        typer.Option(help="Response table, as `learn` writes it, for the tracker of --params."),
    ] = None,
    scenario: Annotated[
        list[str] | None,
        typer.Option(
            help="Built-in scenario or world, or a pattern such as 'report_*'; may be given several"
            " times.  [default: all scenarios]"
        ),
    ] = None,
    targets: Annotated[
        bool,
        typer.Option(
            "--targets",
            help="Judge trackers of targets instead, from the first box, beside those of OpenCV.",
        ),
    ] = False,
    source: Annotated[
        Path | None, typer.Option(help="A labelled recording instead of the scenarios.")
    ] = None,
    truth: TruthOption = None,
    unlabelled_is_empty: Annotated[
        bool,
        typer.Option(
            "--unlabelled-is-empty",
            help="Frames of the recording without a label show no cable, with --targets no target;"
            " else they do not count.",
        ),
    ] = False,
    first_seed: FirstSeedOption = 0,
    seeds: SeedsOption = 3,
    init: Annotated[
        Start, typer.Option(help="Tell the methods where the cable is in the first frame, or not.")
    ] = Start.TRUTH,
    frames: Annotated[
        int | None,
        typer.Option(help="Number of frames used of each scenario.  [default: all]", min=1),
    ] = None,
    output: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("evaluation"),
    force: ForceOption = False,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    memory: MemoryOption = MEMORY,
    dashboard: DashboardOption = False,
    resume: ResumeOption = False,
    topic: TopicOption = None,
    rate: RateOption = None,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
) -> None:
    """Judge methods against ground truth and write a report.

    The folder holds report.html, which needs nothing else, and all numbers as CSV. The same command
    gives the same numbers, except for the times. With --targets it holds table.md and figures.csv.
    """
    of_recordings = {
        "--truth": truth, "--unlabelled-is-empty": unlabelled_is_empty, "--topic": topic,
        "--rate": rate, "--skip-bad-frames": skip_bad_frames, "--allow-outside": allow_outside,
    }  # fmt: skip
    if source is None:
        refuse_without_effect(of_recordings, "can only do something for a recording, --source")
    else:
        of_scenarios = {"--scenario": bool(scenario), "--frames": frames}
        refuse_without_effect(of_scenarios, "can do nothing with --source")
    if targets:
        is_cold = init is not Start.TRUTH
        of_cables = {"--param": bool(param), "--table": table, "--init": is_cold}
        refuse_without_effect(of_cables, "can do nothing with --targets")
    cluster = chosen_cluster(workers, scheduler, memory, dashboard)
    numbers = seeds_from(seeds, first_seed)
    recording = None
    if source is not None:
        # Links stay links: their names are those that the user knows.
        path, labels = source.absolute(), truth and truth.absolute()
        recording = LabelledRecording(
            path, topic, rate, labels, skip_bad_frames, allow_outside,
            unlabelled_is_empty=unlabelled_is_empty,
        )  # fmt: skip
    if targets:
        tuned = tuned_targets(params)
        target_sequences = _target_sequences(recording, scenario or (), frames)
        followed = TargetCampaign(target_sequences, numbers, chosen_methods(method, tuned), tuned)
        evaluate_targets(followed, output, cluster, force=force, resume=resume)
    else:
        filters = tuned_filters(params, param, table)
        sequences = _cable_sequences(recording, scenario or (), frames)
        campaign = _cable_campaign(method, sequences, numbers, init, filters)
        evaluate_cables(campaign, output, cluster, force=force, resume=resume)


def _target_sequences(
    recording: LabelledRecording | None, scenarios: Sequence[str], frames: int | None
) -> tuple[TargetSequence, ...]:
    """Return a recording to judge trackers of targets on, or else scenarios."""
    if recording is not None:
        return (_as_sequence(RecordedTarget, recording),)
    return simulated_targets(scenarios, frames)


def _cable_sequences(
    recording: LabelledRecording | None, scenarios: Sequence[str], frames: int | None
) -> tuple[EvaluationSequence, ...]:
    """Return a recording to judge trackers of cables on, or else scenarios and worlds."""
    if recording is not None:
        return (_as_sequence(RecordingSequence, recording),)
    sequences, left_out = available_sequences(scenarios, frames)
    print_left_out(left_out)
    return tuple(sequences)


def _as_sequence(kind: type[Recording], recording: LabelledRecording) -> Recording:
    return kind(**asdict(recording))


def _cable_campaign(
    methods: Sequence[str] | None,
    sequences: tuple[EvaluationSequence, ...],
    seeds: tuple[int, ...],
    start: Start,
    filters: tuple[ConfiguredFilter, ...],
) -> Campaign:
    """Return the cable trackers to judge: the methods that are named, or else the usual ones."""
    usual = ("default",) if filters else tuple(METHODS)
    return Campaign(
        methods=tuple(dict.fromkeys(methods or usual)),
        sequences=sequences,
        seeds=seeds,
        start=start,
        with_sheets=True,
        filters=filters,
    )
