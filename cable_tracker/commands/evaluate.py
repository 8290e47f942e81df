"""`cable-tracker evaluate`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import Annotated, TypeVar

import typer
from rich.table import Table

from cable_tracker.campaigns.crew import ClusterSettings, move_store, stored_beside
from cable_tracker.commands.machine import machine, typed_command
from cable_tracker.commands.options import (
    MEMORY,
    DashboardOption,
    ForceOption,
    MemoryOption,
    OutsideOption,
    RateOption,
    ResumeOption,
    SchedulerOption,
    SkipOption,
    TopicOption,
    TruthOption,
)
from cable_tracker.commands.target_campaign import (
    TargetCampaign,
    chosen_methods,
    evaluate_targets,
    simulated_targets,
    tuned_targets,
)
from cable_tracker.commands.terminal import advance, console, messages, progress_bar
from cable_tracker.commands.tuning import ValueOption, chosen_parameters, given_values
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.campaign import Campaign, run_campaign
from cable_tracker.evaluation.judged_sequences import (
    JudgedSequence,
    RecordingSequence,
    simulated_sequences,
)
from cable_tracker.evaluation.labelled_recording import LabelledRecording
from cable_tracker.evaluation.methods import METHODS, ConfiguredFilter
from cable_tracker.evaluation.report import (
    REPORT,
    ReportHeader,
    TableView,
    summary_table,
    write_report,
)
from cable_tracker.evaluation.runs import Start
from cable_tracker.evaluation.tables import CSV_FILES
from cable_tracker.evaluation.targets.target_sequences import RecordedTarget
from cable_tracker.sequences.output_folder import output_folder

Recording = TypeVar("Recording", bound=LabelledRecording)

TITLE = "How well the cable is followed"

PRINTED_METRICS = (
    "useful", "wrong_claims", "false_tracking", "longest_loss", "held_rmse_d", "held_rmse_alpha",
    "start_right", "ms",
)  # fmt: skip
"""What fits on a terminal; the report has more."""

LARGEST_FIRST_SEED = 1_000_000_000
"""Far enough below the largest seed of a tracker for all that is added to it."""

FirstSeedOption = Annotated[
    int, typer.Option(help="Seed of the first run; keep seeds for tuning and for reports apart.")
]
SeedsOption = Annotated[
    int, typer.Option(help="Number of runs, with the first seed and those that follow it.")
]
WorkersOption = Annotated[
    int | None, typer.Option(help="Number of processes.  [default: one for each processor]")
]


def worker_count(workers: int | None) -> int:
    """Return the number of processes when the user names none."""
    return workers if workers is not None else os.cpu_count() or 1


def chosen_cluster(
    workers: int | None, scheduler: str | None, memory: str, dashboard: bool
) -> ClusterSettings:
    """Return where tasks run, and say where Dask's pages are."""
    if dashboard:
        messages.print("Dask's pages: http://127.0.0.1:8787/status")
    return ClusterSettings(worker_count(workers), scheduler, memory, dashboard)


def seeds_from(count: int, first: int = 0) -> tuple[int, ...]:
    """Return so many seeds from a first one upwards.

    Raises
    ------
    ParameterError
        The count is not positive, or the first seed out of range.
    """
    if count < 1:
        raise ParameterError(f"seeds is {count}: give at least 1")
    if not 0 <= first <= LARGEST_FIRST_SEED:
        raise ParameterError(f"first-seed is {first}: give 0 to {LARGEST_FIRST_SEED}")
    return tuple(range(first, first + count))


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
        int | None, typer.Option(help="Use only so many frames of each scenario.", min=1)
    ] = None,
    output: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("evaluation"),
    force: ForceOption = False,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    memory: MemoryOption = MEMORY,
    dashboard: DashboardOption = False,
    resume: ResumeOption = False,
    topic: TopicOption = None,
    rate: RateOption = 25.0,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
) -> None:
    """Judge methods against ground truth and write a report.

    The folder holds report.html, which needs nothing else, and all numbers as CSV. The same command
    gives the same numbers, except for the times. With --targets it holds table.md and figures.csv.
    """
    sequences: Sequence[JudgedSequence]

    def as_chosen(kind: type[Recording], path: Path) -> Recording:
        chosen = (topic, rate, truth, skip_bad_frames, allow_outside)
        return kind(path, *chosen, unlabelled_is_empty=unlabelled_is_empty)

    if source is not None and (scenario or frames):
        raise ParameterError("--source takes the place of --scenario and --frames; leave those out")
    if source is None and truth is not None:
        raise ParameterError("--truth labels a recording; give it with --source")
    cluster = chosen_cluster(workers, scheduler, memory, dashboard)
    if targets:
        if param or table or init is not Start.TRUTH:
            raise ParameterError("--targets goes without --param, --table and --init")
        recorded = source and as_chosen(RecordedTarget, source)
        tuned = tuned_targets(params)
        followed = TargetCampaign(
            (recorded,) if recorded else simulated_targets(scenario or (), frames),
            seeds_from(seeds, first_seed),
            chosen_methods(method, tuned),
            tuned,
        )
        evaluate_targets(followed, output, cluster, force=force, resume=resume)
        return
    if source is None:
        sequences = simulated_sequences(scenario or (), frames)
    else:
        sequences = (as_chosen(RecordingSequence, source),)
    filters = tuned_filters(params, param, table)
    campaign = Campaign(
        methods=tuple(dict.fromkeys(method or (("default",) if filters else METHODS))),
        sequences=tuple(sequences),
        seeds=seeds_from(seeds, first_seed),
        start=init,
        with_sheets=True,
        filters=filters,
    )
    header = ReportHeader(TITLE, typed_command(), machine(), date.today().isoformat())
    total = campaign.frame_count()
    with (
        output_folder(output, REPORT, overwrite=force or resume) as folder,
        stored_beside(output, cluster, resume=resume) as crew,
    ):
        with progress_bar("evaluating", total) as progress:
            results = run_campaign(
                campaign, workers=crew, advance=lambda count: advance(progress, count)
            )
        move_store(crew, folder)
        with progress_bar("writing the report", None):
            write_report(
                folder,
                results,
                header,
                methods={name: METHODS[name].description for name in campaign.methods}
                | {each.name: "particle filter with parameters of yours" for each in filters},
                sequences={each.name: each.description for each in sequences},
            )
    print_table(summary_table(results, PRINTED_METRICS))
    for name in (REPORT, *(name for name, _ in CSV_FILES)):
        console.print(f"  {output / name}", soft_wrap=True)


def tuned_filters(
    files: Sequence[Path] | None, words: Sequence[str] | None, table: Path | None
) -> tuple[ConfiguredFilter, ...]:
    """Return the trackers with parameters of the user's: one for each file, or one for the words.

    Parameters
    ----------
    files : sequence of Path or None
        Parameter files; each tracker is named after its file.
    words : sequence of str or None
        Single values, `name=value`, for all of them.
    table : Path or None
        Response table for all of them.

    Raises
    ------
    ParameterError
        A value is not acceptable, two files have one name, or a file is named like a method.
    """
    more = given_values(None, words)
    if table is not None:
        more["response_table"] = str(table.resolve())
    if not (files or more):
        return ()
    given = {file.stem: given_values(file, None) for file in files or ()} or {"tuned": {}}
    taken = sorted(set(given) & set(METHODS))
    if taken or len(given) < len(files or ()):
        raise ParameterError(
            f"--params: {', '.join(taken) or 'a file name'} stands for two methods; rename a file"
        )
    return tuple(
        ConfiguredFilter(name, chosen_parameters(None, values | more, None))
        for name, values in given.items()
    )


def print_table(view: TableView) -> None:
    """Print a table of the report on the terminal."""
    table = Table(title="means over all runs")
    table.add_column(view.corner, no_wrap=True)
    for label, unit in view.headings:
        table.add_column(f"{label} [{unit}]" if unit else label, justify="right")
    for name, cells in view.rows:
        table.add_row(name, *(cell.text for cell in cells))
    console.print(table)
