"""The tables of a benchmark, for the terminal and for a page of the documentation."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

from cable_tracker.benchmark.cases import REFERENCE_PARTICLES
from cable_tracker.benchmark.footage import RENDERED_SIZE
from cable_tracker.benchmark.goals import Goal, goals_of
from cable_tracker.benchmark.result import BenchmarkResult, Circumstances
from cable_tracker.benchmark.round_robin import Measurement
from cable_tracker.benchmark.statistics import Percentiles, Quartiles
from cable_tracker.evaluation.result_table import ResultTable, table_markdown
from cable_tracker.marked_page import MarkedPage, read_marked_page

BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
"""First and last line of the part of a page that a benchmark writes."""

NOTHING = "–"
SMALLEST = 1e-6
"""Numbers nearer to 0 are 0."""


def tables_of(result: BenchmarkResult) -> list[ResultTable]:
    """Return all tables that have rows."""
    tables = [
        _goal_table(goals_of(result)),
        _frame_table(result),
        _rival_table(result),
        _step_table(result),
        _copy_table(result),
        _node_table(result),
        _growth_table(result),
        _profile_table(result),
        _memory_table(result),
        _start_table(result),
        _contour_table(result),
    ]
    return [table for table in tables if table.rows]


def _number(value: float | None) -> str:
    """Write a number with three significant digits, and no exponent."""
    if value is None or math.isnan(value):
        return NOTHING
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if abs(value) < SMALLEST:
        return "0"
    if abs(value) >= 100:
        return f"{value:.0f}"
    text = f"{value:.3g}"
    return f"{value:.5f}" if "e" in text else text


def _spread(quartiles: Quartiles | None) -> str:
    if quartiles is None:
        return NOTHING
    return f"{_number(quartiles.median)} ({_number(quartiles.low)}–{_number(quartiles.high)})"


def _size(size: tuple[int, int]) -> str:
    return f"{size[0]}x{size[1]}"


def _times_yardstick(measurement: Measurement) -> str:
    ratio = measurement.ratio
    return NOTHING if ratio is None else f"{_number(ratio.median)}x"


def _goal_table(goals: Iterable[Goal]) -> ResultTable:
    rows = []
    for goal in goals:
        unit = f" {goal.unit}" if goal.unit else "x"
        relation = "≥" if goal.at_least else "≤"
        measured = NOTHING if goal.measured is None else f"{_number(goal.measured)}{unit}"
        rows.append((goal.text, f"{relation} {goal.limit:g}{unit}", measured, goal.verdict))
    return ResultTable(("goal", "wanted", "measured", "met"), tuple(rows), "Goals")


def _frame_table(result: BenchmarkResult) -> ResultTable:
    cells: dict[tuple[str, int], dict[tuple[int, int], str]] = {}
    sizes: dict[tuple[int, int], None] = {}
    for each in result.of("frame"):
        label = each.label
        sizes[label.size] = None
        row = cells.setdefault((label.name, label.particles or 0), {})
        row[label.size] = each.skipped or f"{_spread(each.cpu)} = {_times_yardstick(each)}"
    rows = tuple(
        (name, str(count), *(row.get(size, NOTHING) for size in sizes))
        for (name, count), row in cells.items()
    )
    headings = ("preset", "particles", *(f"{_size(size)} [ms]" for size in sizes))
    return ResultTable(headings, rows, "Whole frames: median (quartiles) = times the yardstick")


def _rival_table(result: BenchmarkResult) -> ResultTable:
    ours = [
        each
        for each in result.of("frame")
        if each.label.size == RENDERED_SIZE and each.label.particles == REFERENCE_PARTICLES
    ]
    accuracies = {accuracy.name: accuracy for accuracy in result.accuracies}
    rows = []
    for each in (*ours, *result.of("library"), *result.of("method")):
        label = each.label
        name = label.name
        accuracy = accuracies.get(name)
        errors = (accuracy.lost, accuracy.rmse_d, accuracy.rmse_alpha) if accuracy else (None,) * 3
        rows.append(
            (name, _spread(each.cpu), _times_yardstick(each), *(_number(error) for error in errors))
        )
    rows += [(name, "not installed", *(NOTHING,) * 4) for name in result.circumstances.absent]
    headings = (
        "method", "ms", "yardsticks", "frames lost [%]", "RMSE of d [px]", "RMSE of alpha [deg]",
    )  # fmt: skip
    return ResultTable(headings, tuple(rows), "Against others, 320x240, 500 particles")


def _step_table(result: BenchmarkResult) -> ResultTable:
    rows = tuple(
        (each.label.name, _spread(each.cpu), _times_yardstick(each)) for each in result.of("step")
    )
    return ResultTable(
        ("step", "ms", "yardsticks"), rows, "Steps that can be called alone, 320x240, 500 particles"
    )


def _copy_table(result: BenchmarkResult) -> ResultTable:
    rows = []
    for each in (*result.of("yardstick"), *result.of("copy")):
        label = each.label
        rate = label.amount / each.cpu.median / 1e6 if label.amount and each.cpu else None
        rows.append(
            (
                f"{'copy of ' if label.section == 'copy' else ''}{label.name}",
                _size(label.size),
                _spread(each.cpu),
                _times_yardstick(each),
                _number(rate),
            )
        )
    headings = ("what", "size", "ms", "yardsticks", "GB/s read")
    return ResultTable(headings, tuple(rows), "The yardstick, and plain copies")


def _tail(percentiles: Percentiles | None) -> str:
    if percentiles is None:
        return NOTHING
    return " / ".join(_number(v) for v in (percentiles.median, percentiles.p95, percentiles.p99))


def _node_table(result: BenchmarkResult) -> ResultTable:
    rows = tuple(
        (
            node.name,
            str(node.particles),
            f"{_size(node.size)} at {node.rate:g} Hz",
            _tail(node.state),
            _tail(node.centreline),
            _tail(node.echo),
            _tail(node.in_process),
            f"{100 * node.cpu_share:.1f} %",
            f"{100 * node.echo_cpu_share:.1f} %",
            str(node.unanswered),
        )
        for node in result.nodes
    )
    headings = (
        "preset", "particles", "frames", "`state`", "`centreline`", "echo node",
        "without a node", "processor", "of the echo", "unanswered",
    )  # fmt: skip
    title = "Node to node over DDS: median / 95th / 99th percentile of the latency [ms]"
    return ResultTable(headings, rows, title)


def _growth_table(result: BenchmarkResult) -> ResultTable:
    rows = tuple(
        (
            growth.name,
            growth.variable,
            _number(growth.base),
            _number(growth.each),
            str(growth.points),
        )
        for growth in result.growths
    )
    headings = ("preset", "per", "base [ms]", "each [ns]", "measurements")
    return ResultTable(headings, rows, "How the time of a frame grows")


def _profile_table(result: BenchmarkResult) -> ResultTable:
    rows = tuple(
        (row.name, f"`{row.function}`", f"{row.share:.1f}", _number(row.ms), _number(row.calls))
        for row in result.profile
    )
    headings = ("preset", "function", "own time [%]", "ms per frame", "calls per frame")
    return ResultTable(headings, rows, "What bounds the rest (under the profiler)")


def _memory_table(result: BenchmarkResult) -> ResultTable:
    rows = tuple(
        (
            use.name,
            str(use.frames),
            _number(use.start),
            f"{use.growth:.2f}",
            f"{use.per_thousand:.1f}",
        )
        for use in result.memory
    )
    headings = ("preset", "frames", "begin [MiB]", "growth [MiB]", "slope [KiB per 1000 frames]")
    return ResultTable(headings, rows, "Resident memory of the process")


def _start_table(result: BenchmarkResult) -> ResultTable:
    rows = tuple((each.name, f"{each.cold:.1f}", f"{each.warm:.2f}") for each in result.starts)
    headings = ("preset", "nothing compiled [s]", "everything kept [s]")
    return ResultTable(headings, rows, "Until a tracker is ready, time of the processor")


def _contour_table(result: BenchmarkResult) -> ResultTable:
    rows: list[tuple[str, ...]] = []
    for each in result.contours:
        own = (_number(each.ms), f"{each.overlap:.3f}", str(each.iterations), "1x")
        rows.append(("point switching (Ha 2008), compiled", *own))
        if each.rival_ms is not None and each.rival_overlap is not None:
            rival = (_number(each.rival_ms), f"{each.rival_overlap:.3f}")
            ratio = f"{_number(each.ratio)}x"
            name = "scikit-image, morphological_chan_vese"
            rows.append((name, *rival, str(each.rival_iterations), ratio))
    headings = ("contour", "time of the processor [ms]", "overlap", "iterations", "ratio")
    return ResultTable(headings, tuple(rows), "A contour on 320x240 from a wrong start")


def circumstances_text(circumstances: Circumstances) -> str:
    """Return in Markdown how, where and when it was measured."""
    before, after = (
        ", ".join(f"{load:.2f}" for load in loads)
        for loads in (circumstances.load_before, circumstances.load_after)
    )
    return (
        f"`{circumstances.command}` on {circumstances.date}, {circumstances.machine}."
        f" {circumstances.versions}. One thread, also of OpenCV; load average {before} before,"
        f" {after} after."
    )


def result_markdown(result: BenchmarkResult) -> str:
    """Return all tables as Markdown."""
    parts = [circumstances_text(result.circumstances)]
    parts += [table_markdown(table) for table in tables_of(result)]
    return "\n\n".join(parts) + "\n"


def check_page(path: Path) -> None:
    """Check that a page can be written: a new one, or one with a place for the tables.

    Raises
    ------
    OutputError
        There is a file without such a place.
    """
    if path.exists():
        read_marked_page(path, BEGIN, END)


def write_page(path: Path, content: str) -> None:
    """Write the results into their place on a page, or a new page.

    Raises
    ------
    OutputError
        The page has no such place, or cannot be written.
    """
    new = MarkedPage(BEGIN, "", f"{END}\n")
    page = read_marked_page(path, BEGIN, END) if path.exists() else new
    page.write(path, f"\n\n{content}\n")
