"""`cable-tracker dev bench`."""

from __future__ import annotations

import os
from dataclasses import replace
from datetime import date
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from cable_tracker.atomic_output import output_file
from cable_tracker.benchmark.cases import REFERENCE_PARTICLES, TIMED_PRESETS
from cable_tracker.benchmark.footage import RENDERED_SIZE, footage
from cable_tracker.benchmark.node_timing import NodeTiming
from cable_tracker.benchmark.plan import FULL, QUICK, Benchmark, Plan, absent_libraries, versions
from cable_tracker.benchmark.report import (
    check_page,
    circumstances_text,
    result_markdown,
    tables_of,
    write_page,
)
from cable_tracker.benchmark.result import BenchmarkResult, Circumstances, is_benchmark, to_json
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.commands.console.machine import machine, typed_command
from cable_tracker.commands.console.ros_part import need_ros
from cable_tracker.commands.console.terminal import advance, console, print_table, progress_bar
from cable_tracker.commands.options.common import ForceOption
from cable_tracker.evaluation.result_table import ResultTable

PLANS = {False: FULL, True: QUICK}
"""Plans by whether the benchmark is to be quick."""

NODE_TRIALS = (
    (RENDERED_SIZE, REFERENCE_PARTICLES),
    ((640, 480), REFERENCE_PARTICLES),
    ((640, 480), 10_000),
)
"""Sizes and numbers of particles that are measured from node to node."""


def bench(  # noqa: PLR0917
    output: Annotated[Path, typer.Option(help="File for all numbers, JSON.")] = Path("bench.json"),
    quick: Annotated[
        bool, typer.Option("--quick", help="A part of it, in about a minute.")
    ] = False,
    dds: Annotated[
        bool, typer.Option("--dds", help="Also from node to node, in processes of their own.")
    ] = False,
    dds_frames: Annotated[
        int, typer.Option(help="Frames for each node and each setting.", min=1)
    ] = 240,
    memory: Annotated[
        int | None,
        typer.Option(
            help="Frames over which memory is watched; 0: none.  [default: 10000, quick: 0]", min=0
        ),
    ] = None,
    markdown: Annotated[
        Path | None,
        typer.Option(
            help="Page for the tables, such as docs/performance.md: a new one, or one"
            " that has a place for them."
        ),
    ] = None,
    force: ForceOption = False,
) -> None:
    """Measure how long frames take, beside a yardstick.

    All take turns in one run, so that a busy machine slows all alike; what counts are the ratios
    to the yardstick: the observation of Wirth's thesis for 500 particles, written down literally
    and compiled. Times are those of one processor.
    """
    plan = PLANS[quick] if memory is None else replace(PLANS[quick], memory=memory)
    if markdown is not None:
        check_page(markdown)
    if dds:
        need_ros("rigs.node_latency")
    with output_file(output, is_benchmark, overwrite=force) as file:
        result = _run(plan, dds_frames if dds else 0)
        file.write_text(to_json(result), encoding="utf-8")
    if markdown is not None:
        write_page(markdown, result_markdown(result))
    for table in tables_of(result):
        _print(table)
    console.print(circumstances_text(result.circumstances), soft_wrap=True)
    for path in filter(None, (output, markdown)):
        console.print(f"  {path}", soft_wrap=True)


def _run(plan: Plan, dds_frames: int) -> BenchmarkResult:
    before = os.getloadavg()
    circumstances = Circumstances(
        command=typed_command(without="--output"),
        date=date.today().isoformat(),
        machine=machine(),
        versions=versions(),
        load_before=before,
        load_after=before,
        absent=absent_libraries(),
    )
    with progress_bar("rendering, compiling", None):
        benchmark = Benchmark(plan)
    with progress_bar("measuring", benchmark.turn_count()) as progress:
        result = benchmark.run(circumstances, partial(advance, progress))
    nodes = measure_nodes(plan, dds_frames) if dds_frames else ()
    circumstances = replace(circumstances, load_after=os.getloadavg())
    return replace(result, circumstances=circumstances, nodes=nodes)


def measure_nodes(plan: Plan, frames: int) -> tuple[NodeTiming, ...]:
    """Measure `default` and `thesis` from node to node."""
    from cable_tracker.ros.rigs.node_latency import NodeTrial, measure_node  # noqa: PLC0415

    trials = [
        NodeTrial(
            name,
            preset(name).replaced({"particle_count": particles}),
            footage(plan.frames, size),
            frames,
        )
        for size, particles in NODE_TRIALS
        for name in TIMED_PRESETS
    ]
    timings = []
    for trial in trials:
        width, height = trial.shown.size
        title = f"node {trial.name}, {width}x{height}, {trial.parameters.particle_count}"
        with progress_bar(title, None) as progress:
            timings.append(measure_node(trial, partial(advance, progress)))
    return tuple(timings)


def _print(table: ResultTable) -> None:
    """Print a table of the page without its marks of code."""
    headings, *rows = (
        [cell.replace("`", "") for cell in row] for row in (table.headings, *table.rows)
    )
    print_table(table.title, headings, rows, left=range(len(headings)))
