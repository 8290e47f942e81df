"""`cable-tracker dev experiment`."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.campaigns.result_store import STORE, campaign_folder
from cable_tracker.commands.console.machine import origin_note
from cable_tracker.commands.console.terminal import advance, print_files, print_table, progress_bar
from cable_tracker.commands.options.common import ForceOption
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
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.experiments.ablation import ROW_NAMES, AblationExperiment
from cable_tracker.evaluation.experiments.catalogue import EXPERIMENTS, FILES
from cable_tracker.evaluation.experiments.experiment import (
    TABLE_MARKDOWN,
    Experiment,
    ExperimentResult,
    write_experiment,
)
from cable_tracker.tracking.parameter_table import check_name


def experiment(  # noqa: PLR0917
    name: Annotated[str, typer.Argument(help=" | ".join(EXPERIMENTS))],
    output: Annotated[
        Path | None, typer.Option(help="Folder for the results.  [default: experiment_NAME]")
    ] = None,
    first_seed: FirstSeedOption = 0,
    seeds: SeedsOption = 3,
    row: Annotated[
        list[str] | None,
        typer.Option(
            help=f"Of ablation and ablation_cold: {' | '.join(ROW_NAMES)}; may be given several"
            " times.  [default: all]"
        ),
    ] = None,
    frames: Annotated[
        int | None, typer.Option(help="Number of frames used of each dive.  [default: all]", min=1)
    ] = None,
    force: ForceOption = False,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    memory: MemoryOption = MEMORY,
    dashboard: DashboardOption = False,
    resume: ResumeOption = False,
) -> None:
    """Run an experiment and write its tables and figures.

    sequences: section 5.2.3, from the true beginning. reinitialisation: 5.2.4, a random start every
    100 frames. speed: 5.2.5, time against particles and filter size. ablation: what each part of
    the preset `default` is worth, from the true beginning. ablation_cold: the same on the worlds to
    report on, from cold starts. metres: errors of the metric output. motion: what odometry is
    worth to the filter, sound or broken. roc: useful frames against wrongly claimed ones over the
    thresholds. strips: crisp strips of any width from a cold start. coverage: how often the truth
    lies inside the stated covariance.
    """
    check_name("experiment", name, EXPERIMENTS)
    chosen = _with_rows(EXPERIMENTS[name](seeds_from(seeds, first_seed), frames), row)
    path = output if output is not None else Path(f"experiment_{name}")
    note = origin_note()
    cluster = chosen_cluster(workers, scheduler, memory, dashboard)
    with campaign_folder(
        path, TABLE_MARKDOWN, cluster, force=force, resume=resume, is_own_name=_is_of_experiment
    ) as (folder, settings):
        with progress_bar(name, chosen.frame_count()) as progress:
            result = chosen.run(settings, partial(advance, progress))
        write_experiment(folder, result, note)
    _print(result)
    print_files(path, result.file_names())


def _is_of_experiment(name: str) -> bool:
    """Tell by its name whether an experiment writes a file, also another one than this."""
    return name == STORE or name in FILES


def _with_rows(chosen: Experiment, rows: list[str] | None) -> Experiment:
    if not rows:
        return chosen
    if not isinstance(chosen, AblationExperiment):
        raise ParameterError(
            "--row chooses what the experiments ablation and ablation_cold run; leave it out"
        )
    return replace(chosen, rows=tuple(rows))


def _print(result: ExperimentResult) -> None:
    for each in result.tables:
        rows = (row[: each.brief] for row in each.rows)
        print_table(each.title or result.title, each.headings[: each.brief], rows)
