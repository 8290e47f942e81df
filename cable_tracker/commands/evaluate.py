"""`cable-tracker evaluate`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from cable_tracker.commands.machine import machine, typed_command
from cable_tracker.commands.options import (
    ForceOption,
    OutsideOption,
    RateOption,
    SkipOption,
    TopicOption,
    TruthOption,
)
from cable_tracker.commands.terminal import advance, console, progress_bar
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.campaign import Campaign, run_campaign
from cable_tracker.evaluation.folder import output_folder
from cable_tracker.evaluation.judged_sequences import (
    JudgedSequence,
    RecordingSequence,
    scenario_sequences,
)
from cable_tracker.evaluation.methods import METHODS
from cable_tracker.evaluation.report import (
    REPORT,
    ReportHeader,
    TableView,
    summary_table,
    write_report,
)
from cable_tracker.evaluation.runs import Start
from cable_tracker.evaluation.tables import CSV_FILES

TITLE = "How well the cable is followed"

PRINTED_METRICS = (
    "lost", "longest_loss", "held_rmse_d", "held_rmse_alpha", "silence", "false_tracking",
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
        typer.Option(help=f"{' | '.join(METHODS)}; may be given several times.  [default: all]"),
    ] = None,
    scenario: Annotated[
        list[str] | None,
        typer.Option(
            help="Built-in scenario or world, or a pattern such as 'report_*'; may be given several"
            " times.  [default: all scenarios]"
        ),
    ] = None,
    source: Annotated[
        Path | None, typer.Option(help="A labelled recording instead of the scenarios.")
    ] = None,
    truth: TruthOption = None,
    unlabelled_is_empty: Annotated[
        bool,
        typer.Option(
            "--unlabelled-is-empty",
            help="Frames of the recording without a label show no cable; else they do not count.",
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
    topic: TopicOption = None,
    rate: RateOption = 25.0,
    skip_bad_frames: SkipOption = False,
    allow_outside: OutsideOption = False,
) -> None:
    """Judge methods against ground truth and write a report.

    The folder holds report.html, which needs nothing else, and all numbers as CSV. The same command
    gives the same numbers, except for the times.
    """
    sequences: Sequence[JudgedSequence]
    if source is None:
        if truth is not None:
            raise ParameterError("--truth labels a recording; give it with --source")
        sequences = scenario_sequences(scenario or (), frames)
    elif scenario or frames:
        raise ParameterError("--source takes the place of --scenario and --frames; leave those out")
    else:
        recording = RecordingSequence(
            source, topic, rate, truth, skip_bad_frames, unlabelled_is_empty, allow_outside
        )
        sequences = (recording,)
    campaign = Campaign(
        methods=tuple(dict.fromkeys(method or METHODS)),
        sequences=tuple(sequences),
        seeds=seeds_from(seeds, first_seed),
        start=init,
        with_sheets=True,
    )
    header = ReportHeader(TITLE, typed_command(), machine(), date.today().isoformat())
    total = campaign.frame_count()
    with output_folder(output, REPORT, overwrite=force) as folder:
        with progress_bar("evaluating", total) as progress:
            results = run_campaign(
                campaign,
                workers=worker_count(workers),
                advance=lambda count: advance(progress, count),
            )
        with progress_bar("writing the report", None):
            write_report(
                folder,
                results,
                header,
                methods={name: METHODS[name].description for name in campaign.methods},
                sequences={each.name: each.description for each in sequences},
            )
    print_table(summary_table(results, PRINTED_METRICS))
    for name in (REPORT, *(name for name, _ in CSV_FILES)):
        console.print(f"  {output / name}", soft_wrap=True)


def print_table(view: TableView) -> None:
    """Print a table of the report on the terminal."""
    table = Table(title="means over all runs")
    table.add_column(view.corner, no_wrap=True)
    for label, unit in view.headings:
        table.add_column(f"{label} [{unit}]" if unit else label, justify="right")
    for name, cells in view.rows:
        table.add_row(name, *(cell.text for cell in cells))
    console.print(table)
