"""`cable-tracker experiment`."""

from __future__ import annotations

from datetime import date
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from cable_tracker.commands.evaluate import WorkersOption, seeds_from, worker_count
from cable_tracker.commands.machine import machine, typed_command
from cable_tracker.commands.options import ForceOption
from cable_tracker.commands.terminal import advance, console, progress_bar
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.experiments import (
    EXPERIMENTS,
    TABLE_CSV,
    TABLE_MARKDOWN,
    ExperimentResult,
    write_experiment,
)
from cable_tracker.evaluation.folder import output_folder


def experiment(
    name: Annotated[str, typer.Argument(help=" | ".join(EXPERIMENTS))],
    output: Annotated[
        Path | None, typer.Option(help="Folder for the results.  [default: experiment_NAME]")
    ] = None,
    seeds: Annotated[int, typer.Option(help="Number of runs, with seeds 0, 1, ...")] = 3,
    force: ForceOption = False,
    workers: WorkersOption = None,
) -> None:
    """Repeat an experiment of Wirth's thesis, and write its table and figures.

    sequences: section 5.2.3, from the true beginning. reinitialisation: 5.2.4, a random start every
    100 frames. speed: 5.2.5, time against particles and filter size.
    """
    if name not in EXPERIMENTS:
        raise ParameterError(f"experiment: {name!r} is none of {' | '.join(EXPERIMENTS)}")
    chosen = EXPERIMENTS[name](seeds_from(seeds))
    path = output if output is not None else Path(f"experiment_{name}")
    note = f"`{typed_command()}` on {date.today().isoformat()}, {machine()}."
    with output_folder(path, TABLE_MARKDOWN, overwrite=force) as folder:
        with progress_bar(name, chosen.frame_count()) as progress:
            result = chosen.run(worker_count(workers), lambda count: advance(progress, count))
        write_experiment(folder, result, note)
    _print(result)
    for file_name in (TABLE_MARKDOWN, TABLE_CSV, *(p.file_name for p in result.pictures)):
        console.print(f"  {path / file_name}", soft_wrap=True)


def _print(result: ExperimentResult) -> None:
    table = Table(title=result.title)
    for heading in result.headings:
        table.add_column(heading, justify="right")
    for row in result.rows:
        table.add_row(*row)
    console.print(table)
