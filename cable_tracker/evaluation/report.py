"""The report of an evaluation: one HTML file that needs nothing else, and tables as CSV."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from cable_tracker.atomic_output import write_bytes
from cable_tracker.cable.model.state import POSE_SYMBOLS
from cable_tracker.evaluation.errors import LOST_DISTANCE
from cable_tracker.evaluation.figures import as_svg, calibration_figure, loss_figure, trace_figure
from cable_tracker.evaluation.result_table import format_number
from cable_tracker.evaluation.run_metrics import (
    CLEARLY_BACK,
    METRIC_TABLE,
    METRICS_BY_NAME,
    RETURN_SECONDS,
    START_FRAMES,
    MetricSpec,
)
from cable_tracker.evaluation.runs import RunResult, chosen, methods_of, metric_spread, sequences_of
from cable_tracker.evaluation.sample_statistics import Spread
from cable_tracker.sequences.tables.csv_tables import csv_text
from cable_tracker.sequences.tables.estimates import format_stamp

REPORT = "report.html"
TEMPLATE = "report.html.j2"

SUMMARY_METRICS = (
    "useful", "wrong_claims", "false_tracking", "longest_loss", "recovery", "held_rmse_d",
    "held_rmse_alpha", "held_rmse_w", "held_rmse_beta", "silence", "found_again", "start_right",
    "start_wrong", "inside_2_sigma_d", "inside_2_sigma_alpha", "inside_2_sigma_w",
    "inside_2_sigma_beta", "nees_median", "ms",
)  # fmt: skip
"""Columns of the first table; a column of which nothing is known is left out."""

MATRIX_METRICS = (
    "useful",
    "wrong_claims",
    "held_rmse_d",
    "held_rmse_alpha",
    "silence",
    "false_tracking",
    "found_again",
)
"""Numbers that get a table of sequences by methods."""

SEQUENCE_METRICS = (
    "useful", "lost", "longest_loss", "recovery", "unrecovered", "silence", "wrong_claims",
    "false_tracking", "returns", "found_again", "time_to_find", "start_right", "start_wrong",
    "frames_to_right", "inside_region", "nees_median", "ms",
)  # fmt: skip

ERROR_MEASURES = ("bias", "rmse", "median", "p95")

FRAME_HEADINGS = (
    "sequence", "method", "seed", "frame", "stamp [s]", "status", "visibility", "lost",
    "true_d [px]", "true_alpha [rad]", "true_w [px]", "true_beta [rad]",
    "d [px]", "alpha [rad]", "w [px]", "beta [rad]",
    "sigma_d [px]", "sigma_alpha [rad]", "sigma_w [px]", "sigma_beta [rad]", "ms",
)  # fmt: skip

SUMMARY_HEADINGS = (
    "sequence", "method", "metric", "unit", "runs",
    "mean", "standard_error", "median", "minimum", "maximum",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ReportHeader:
    """Header of a report.

    Attributes
    ----------
    title : str
        Title of the report.
    command : str
        Command line that wrote the report.
    machine : str
        Processor, operating system, versions.
    date : str
        Date of the report.
    """

    title: str
    command: str
    machine: str
    date: str


@dataclass(frozen=True, slots=True)
class Cell:
    """One number of a table.

    Attributes
    ----------
    text : str
        The mean over the runs.
    detail : str
        Smallest and largest; empty if there is no spread.
    shade : float
        Darkness of the background, 0 to 1.
    """

    text: str
    detail: str = ""
    shade: float = 0.0


@dataclass(frozen=True, slots=True)
class TableView:
    """A table: headings with units, and rows that begin with a name."""

    title: str
    corner: str
    headings: tuple[tuple[str, str], ...]
    rows: tuple[tuple[str, tuple[Cell, ...]], ...]


@dataclass(frozen=True, slots=True)
class MethodView:
    """One method on one sequence: a figure and a contact sheet of the first seed."""

    name: str
    caption: str
    figure: str
    sheet: str


@dataclass(frozen=True, slots=True)
class SequenceView:
    """Everything about one sequence. Pictures are data URIs."""

    name: str
    anchor: str
    description: str
    facts: str
    table: TableView
    errors: TableView
    loss: str
    methods: tuple[MethodView, ...]


def write_report(
    folder: Path,
    results: Sequence[RunResult],
    header: ReportHeader,
    *,
    methods: Mapping[str, str],
    sequences: Mapping[str, str],
) -> None:
    """Write report and tables into a folder.

    Parameters
    ----------
    folder : Path
        An existing folder.
    results : sequence of RunResult
        At least one.
    methods, sequences : mapping of str to str
        Descriptions of methods and sequences, by name.

    Raises
    ------
    OutputError
        A file cannot be written.
    """
    for name, make in CSV_FILES:
        write_bytes(folder / name, _bytes_of(make(results)))
    report = render_report(results, header, methods=methods, sequences=sequences)
    write_bytes(folder / REPORT, _bytes_of(report))


def _bytes_of(text: str) -> bytes:
    """Return a text in UTF-8, with ? for the letters of recordings' names that are not."""
    return text.encode(errors="replace")


def render_report(
    results: Sequence[RunResult],
    header: ReportHeader,
    *,
    methods: Mapping[str, str],
    sequences: Mapping[str, str],
) -> str:
    """Return the report as HTML, with all pictures in it; see `write_report`."""
    environment = Environment(
        loader=PackageLoader("cable_tracker.evaluation"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(TEMPLATE).render(
        header=header,
        methods=[(name, methods.get(name, "")) for name in methods_of(results)],
        summary=summary_table(results),
        matrices=[
            _matrix(results, METRICS_BY_NAME[name])
            for name in MATRIX_METRICS
            if len(sequences_of(results)) > 1 and _is_known(results, METRICS_BY_NAME[name])
        ],
        calibration=_svg_uri(as_svg(calibration_figure(results))),
        sequences=[
            _sequence_view(number, sequences.get(name, ""), chosen(results, sequence=name))
            for number, name in enumerate(sequences_of(results))
        ],
        runs_uri=_data_uri("text/csv", _bytes_of(runs_csv(results))),
        start=results[0].start.value,
        seeds=seeds_text(result.seed for result in results),
        run_count=len(results),
        frame_count=sum(len(result.trace) for result in results),
        lost_distance=LOST_DISTANCE,
        start_frames=START_FRAMES,
        return_seconds=RETURN_SECONDS,
        clearly_back=CLEARLY_BACK,
    )


def seeds_text(seeds: Iterable[int]) -> str:
    """Name the seeds in a few words."""
    known = sorted(set(seeds))
    if len(known) == 1:
        return f"seed {known[0]}"
    if known == list(range(known[0], known[-1] + 1)):
        return f"seeds {known[0]} to {known[-1]}"
    return f"seeds {', '.join(map(str, known))}"


def _data_uri(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def _svg_uri(svg: str) -> str:
    return _data_uri("image/svg+xml", svg.encode())


def _is_known(results: Iterable[RunResult], spec: MetricSpec) -> bool:
    return any(not math.isnan(result.metrics[spec.name]) for result in results)


def make_cell(spread: Spread, unit: str) -> Cell:
    """Write a number over several runs: its mean, and where the runs differ their range."""
    text = format_number(spread.mean, unit)
    low, high = (format_number(value, unit) for value in (spread.minimum, spread.maximum))
    detail = f"{low} – {high}" if spread.count > 1 and low != high else ""
    # Only shares have a natural darkest: all of them.
    shade = spread.mean / 100.0 if unit == "%" and math.isfinite(spread.mean) else 0.0
    return Cell(text, detail, round(min(max(shade, 0.0), 1.0), 3))


GOOD_WHEN_LARGE = (
    "useful", "start_right", "found_again", "inside_2_sigma_d", "inside_2_sigma_alpha",
    "inside_2_sigma_w", "inside_2_sigma_beta", "inside_region",
)  # fmt: skip
"""Shares that are not shaded, for there more is better."""


def _cell(spec: MetricSpec, results: Iterable[RunResult]) -> Cell:
    cell = make_cell(metric_spread(spec.name, results), spec.unit)
    return Cell(cell.text, cell.detail) if spec.name in GOOD_WHEN_LARGE else cell


def _metrics_table(title: str, results: Sequence[RunResult], names: Sequence[str]) -> TableView:
    specs = [METRICS_BY_NAME[name] for name in names if _is_known(results, METRICS_BY_NAME[name])]
    rows = tuple(
        (method, tuple(_cell(spec, chosen(results, method=method)) for spec in specs))
        for method in methods_of(results)
    )
    return TableView(title, "method", tuple((spec.label, spec.unit) for spec in specs), rows)


def summary_table(
    results: Sequence[RunResult], names: Sequence[str] = SUMMARY_METRICS
) -> TableView:
    """Return a table of methods over everything; `names` are keys of `METRICS_BY_NAME`."""
    return _metrics_table("All sequences", results, names)


def _matrix(results: Sequence[RunResult], spec: MetricSpec) -> TableView:
    methods = methods_of(results)
    rows = tuple(
        (
            sequence,
            tuple(_cell(spec, chosen(results, sequence=sequence, method=m)) for m in methods),
        )
        for sequence in sequences_of(results)
        if _is_known(chosen(results, sequence=sequence), spec)
    )
    title = f"{spec.title[0].upper()}{spec.title[1:]}"
    return TableView(title, "sequence", tuple((method, "") for method in methods), rows)


def _error_table(results: Sequence[RunResult]) -> TableView:
    names = [f"{measure}_{axis}" for axis in POSE_SYMBOLS for measure in ERROR_MEASURES]
    return _metrics_table("Errors over all frames with a visible cable", results, names)


def _sequence_view(number: int, description: str, results: Sequence[RunResult]) -> SequenceView:
    first = {result.method: result for result in reversed(results)}
    trace = results[0].trace
    facts = (
        f"{len(trace)} frames, {trace.seconds:.1f} s, {int(trace.visible.sum())} of them with a"
        f" visible cable, {int(trace.hidden.sum())} without one (seed {results[0].seed})"
    )
    return SequenceView(
        name=results[0].sequence,
        anchor=f"sequence-{number}",
        description=description,
        facts=facts,
        table=_metrics_table("", results, SEQUENCE_METRICS),
        errors=_error_table(results),
        loss=_svg_uri(as_svg(loss_figure(results))) if trace.visible.any() else "",
        methods=tuple(_method_view(first[method]) for method in methods_of(results)),
    )


def describe_refusals(result: RunResult) -> str:
    """Describe how many frames a method refused in a run, at least one, and why the first."""
    frames = "1 frame was" if result.refused == 1 else f"{result.refused} frames were"
    return f"{frames} refused and taken as not claimed ({result.refusal})"


def _method_view(result: RunResult) -> MethodView:
    lost = result.metrics["lost"]
    caption = f"seed {result.seed}"
    if not math.isnan(lost):
        caption += f": {lost:.1f} % of the frames lost"
        caption += f", longest loss {result.metrics['longest_loss']:.2f} s" if lost else ""
    if result.refused:
        caption += f"; {describe_refusals(result)}"
    return MethodView(
        name=result.method,
        caption=caption,
        figure=_svg_uri(as_svg(trace_figure([("", result.trace)]))),
        sheet=_data_uri("image/jpeg", result.sheet) if result.sheet else "",
    )


def _text(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.6g}"


def runs_csv(results: Iterable[RunResult]) -> str:
    """Return a table with one row for each run and a column for each number about it."""
    headings = ("sequence", "method", "seed", "start", *(spec.heading for spec in METRIC_TABLE))
    return csv_text(headings, (_run_row(result) for result in results))


def _run_row(result: RunResult) -> list[str]:
    numbers = (_text(result.metrics[spec.name]) for spec in METRIC_TABLE)
    return [result.sequence, result.method, str(result.seed), result.start.value, *numbers]


def summary_csv(results: Sequence[RunResult]) -> str:
    """Return a table with one row for each number of each method on each sequence, over seeds."""
    return csv_text(SUMMARY_HEADINGS, _summary_rows(results))


def _summary_rows(results: Sequence[RunResult]) -> Iterable[Sequence[str]]:
    for sequence in sequences_of(results):
        for method in methods_of(results):
            runs = chosen(results, sequence=sequence, method=method)
            for spec in METRIC_TABLE:
                spread = metric_spread(spec.name, runs)
                numbers = (
                    spread.mean,
                    spread.standard_error,
                    spread.median,
                    spread.minimum,
                    spread.maximum,
                )
                yield (
                    sequence, method, spec.name, spec.unit, str(spread.count),
                    *(_text(number) for number in numbers),
                )  # fmt: skip


def frames_csv(results: Iterable[RunResult]) -> str:
    """Return a table with one row for each frame of each run."""
    rows = (row for result in results for row in _frame_rows(result))
    return csv_text(FRAME_HEADINGS, rows)


def _frame_rows(result: RunResult) -> Iterable[Sequence[str]]:
    trace = result.trace
    numbers = np.hstack((trace.truths, trace.estimates, trace.sigmas, trace.ms[:, None]))
    lost, visible = trace.lost, trace.visible
    for place, values in enumerate(numbers):
        yield (
            result.sequence,
            result.method,
            str(result.seed),
            str(trace.frames[place]),
            format_stamp(int(trace.stamps[place])),
            trace.statuses[place].value,
            _text(trace.visibility[place]),
            str(int(lost[place])) if visible[place] else "",
            *(_text(value) for value in values),
        )


CSV_FILES: tuple[tuple[str, Callable[[Sequence[RunResult]], str]], ...] = (
    ("runs.csv", runs_csv),
    ("summary.csv", summary_csv),
    ("frames.csv", frames_csv),
)
"""Names of the tables in the folder of an evaluation, and what makes them."""
