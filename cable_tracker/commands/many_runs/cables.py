"""`cable-tracker evaluate`: cable filters and other methods, on the same frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import date
from functools import partial
from pathlib import Path

from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.campaigns.result_store import STORE, campaign_folder
from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.commands.console.machine import machine, typed_command
from cable_tracker.commands.console.terminal import (
    advance,
    console,
    print_files,
    print_note,
    print_table,
    progress_bar,
)
from cable_tracker.commands.options.many_runs import with_whole_paths
from cable_tracker.commands.options.parameters import chosen_parameters, single_values
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.methods import METHODS, ConfiguredFilter
from cable_tracker.evaluation.report import (
    CSV_FILES,
    REPORT,
    ReportHeader,
    TableView,
    describe_refusals,
    summary_table,
    write_report,
)
from cable_tracker.evaluation.runs import Campaign, RunResult, Start, evaluate_methods
from cable_tracker.followed_kinds import CABLE

TITLE = "How well the cable is followed"

OWN_NAMES = frozenset({REPORT, STORE, *(name for name, _ in CSV_FILES)})
"""All that is ever written into the folder of an evaluation."""

PRINTED_METRICS = (
    "useful", "wrong_claims", "false_tracking", "longest_loss", "held_rmse_d", "held_rmse_alpha",
    "start_right", "ms",
)  # fmt: skip
"""Metrics that fit on a terminal; the report has more."""

START_NOTES = {
    Start.TRUTH: (
        "told where the cable is in the first frame, if that has a label; --init random for a cold"
        " start"
    ),
    Start.RANDOM: "not told where the cable is, a cold start; --init truth tells it",
}
"""What is said of how the runs began."""


def tuned_filters(
    files: Sequence[Path] | None, assignments: Sequence[str] | None, table: Path | None
) -> tuple[ConfiguredFilter, ...]:
    """Return the trackers with parameters of the user's: one for each file, or one.

    Parameters
    ----------
    files : sequence of Path or None
        Parameter files; each tracker is named after its file.
    assignments : sequence of str or None
        Single values, `name=value`, for all of them.
    table : Path or None
        Response table for all of them.

    Raises
    ------
    ParameterError
        A value is not acceptable, two files have one name, or a file is named like a method.
    """
    if not (files or assignments or table is not None):
        return ()
    given: dict[str, Path | None] = {file.stem: file for file in files or ()} or {"tuned": None}
    taken = sorted(set(given) & set(METHODS))
    if taken or len(given) < len(files or ()):
        raise ParameterError(
            f"--params: {', '.join(taken) or 'a file name'} stands for two methods; rename a file"
        )
    single = single_values(assignments)
    return tuple(
        ConfiguredFilter(name, _tuned(file, single, table)) for name, file in given.items()
    )


def _tuned(
    file: Path | None, single: Mapping[str, object], table: Path | None
) -> TrackerParameters:
    """Return the parameters that a file, single values and a response table make."""
    _, parameters = chosen_parameters(CABLE, None, file, single, None)
    if table is not None:
        parameters = parameters.replaced({"response_table": str(table)})
    return with_whole_paths(parameters)


def evaluate_cables(
    campaign: Campaign, output: Path, cluster: ClusterSettings, *, force: bool, resume: bool
) -> None:
    """Judge, write the report and its tables into a folder, and print the summary.

    Raises
    ------
    OutputError
        The folder is there already, or cannot be written.
    RecordingError
        A recording cannot be judged.
    """
    header = ReportHeader(TITLE, typed_command(), machine(), date.today().isoformat())
    total = campaign.frame_count()
    with campaign_folder(
        output, REPORT, cluster, force=force, resume=resume, is_own_name=OWN_NAMES.__contains__
    ) as (folder, settings):
        with progress_bar("evaluating", total) as progress:
            results = evaluate_methods(campaign, settings, advance=partial(advance, progress))
        with progress_bar("writing the report", None):
            write_report(
                folder,
                results,
                header,
                methods=_descriptions(campaign),
                sequences={each.name: each.description for each in campaign.sequences},
            )
    _print(summary_table(results, PRINTED_METRICS))
    _print_refusals(results)
    console.print(f"  runs: {START_NOTES[campaign.start]}", soft_wrap=True)
    print_files(output, (REPORT, *(name for name, _ in CSV_FILES)))


def _descriptions(campaign: Campaign) -> dict[str, str]:
    """Return the description of each method of a campaign by its name."""
    tuned = dict.fromkeys(
        (each.name for each in campaign.filters), "particle filter with parameters of yours"
    )
    return {name: METHODS[name].description for name in campaign.methods} | tuned


def _print_refusals(results: Sequence[RunResult]) -> None:
    """Print which methods refused frames of which sequence, once for all seeds."""
    refusing = {(each.sequence, each.method): each for each in results if each.refused}
    for (sequence, method), result in refusing.items():
        print_note(f"{method} on {sequence}: {describe_refusals(result)}")


def _print(view: TableView) -> None:
    """Print a table of the report on the terminal."""
    labels = (f"{label} [{unit}]" if unit else label for label, unit in view.headings)
    rows = ((name, *(cell.text for cell in cells)) for name, cells in view.rows)
    print_table("means over all runs", (view.corner, *labels), rows, left=(0,), narrow=True)
