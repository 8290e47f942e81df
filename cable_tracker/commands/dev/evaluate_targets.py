"""`cable-tracker dev evaluate-targets`."""

from __future__ import annotations

from datetime import date
from pathlib import Path
from typing import Annotated

import cv2
import typer

from cable_tracker.campaigns.crew import move_store, run_all, stored_beside
from cable_tracker.commands.evaluate import (
    FirstSeedOption,
    SeedsOption,
    WorkersOption,
    chosen_cluster,
    seeds_from,
)
from cable_tracker.commands.machine import machine, typed_command
from cable_tracker.commands.options import (
    MEMORY,
    DashboardOption,
    ForceOption,
    MemoryOption,
    ResumeOption,
    SchedulerOption,
)
from cable_tracker.commands.terminal import advance, console, messages, progress_bar
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.folder import output_folder
from cable_tracker.evaluation.targets.comparison import (
    ScenarioTask,
    markdown_table,
    method_names,
    write_figures,
)
from cable_tracker.evaluation.targets.peers import MISSING_PEERS, PEERS
from cable_tracker.simulation.targets.scenarios import TARGET_SCENARIOS

FIGURES_CSV = "figures.csv"
TABLE_MARKDOWN = "table.md"
FRAMES = 150


def evaluate_targets(  # noqa: PLR0917
    output: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("targets"),
    scenario: Annotated[
        list[str] | None,
        typer.Option(help=f"{' | '.join(TARGET_SCENARIOS)}; may be given several times."),
    ] = None,
    method: Annotated[
        list[str] | None,
        typer.Option(
            help=f"{' | '.join(method_names())}; may be given several times."
            "  [default: default, thesis, the trackers of OpenCV, and grey default]"
        ),
    ] = None,
    first_seed: FirstSeedOption = 0,
    seeds: SeedsOption = 5,
    force: ForceOption = False,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    memory: MemoryOption = MEMORY,
    dashboard: DashboardOption = False,
    resume: ResumeOption = False,
) -> None:
    """Compare target filters with the trackers of OpenCV.

    All follow the same frames, from the first box. CSRT and KCF are in the wheel
    opencv-contrib-python-headless before 5.0, which takes the place of opencv-python-headless.
    """
    scenarios = tuple(scenario or [name for name in TARGET_SCENARIOS if name != "nothing"])
    methods = tuple(method or ["default", "thesis", *PEERS, "grey default"])
    for name, known in [(n, list(TARGET_SCENARIOS)) for n in scenarios] + [
        (n, method_names()) for n in methods
    ]:
        if name not in known:
            raise ParameterError(f"{name!r} is none of {' | '.join(known)}")
    missing = _words_on_missing()
    if missing:
        messages.print(missing, style="bold yellow", soft_wrap=True)
    tasks = [
        ScenarioTask(name, seed, methods, FRAMES)
        for seed in seeds_from(seeds, first_seed)
        for name in scenarios
    ]
    cluster = chosen_cluster(workers, scheduler, memory, dashboard)
    with (
        output_folder(output, TABLE_MARKDOWN, overwrite=force or resume) as folder,
        stored_beside(output, cluster, resume=resume) as crew,
    ):
        with progress_bar("targets", len(tasks) * FRAMES) as progress:
            parts = run_all(
                tasks,
                workers=crew,
                advance=lambda count: advance(progress, count),
            )
        move_store(crew, folder)
        results = [each for part in parts for each in part]
        note = f"`{typed_command()}` on {date.today().isoformat()}, {machine()}. {missing}".rstrip()
        table = markdown_table(results, methods, note)
        write_figures(folder / FIGURES_CSV, results)
        (folder / TABLE_MARKDOWN).write_text(table, encoding="utf-8")
    console.print(table)
    for file_name in (FIGURES_CSV, TABLE_MARKDOWN):
        console.print(f"  {output / file_name}", soft_wrap=True)


def _words_on_missing() -> str:
    """Say which peers this OpenCV has not, and how to have them; empty where it has all."""
    if not MISSING_PEERS:
        return ""
    return (
        f"NOT COMPARED WITH {' AND '.join(MISSING_PEERS)}: OpenCV {cv2.__version__} has none."
        " Install 'opencv-contrib-python-headless<5' in place of opencv-python-headless, in a"
        " virtual environment of its own."
    )
