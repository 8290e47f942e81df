"""`cable-tracker evaluate --targets`: target filters and their peers, on the same frames."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import filter as matching
from functools import partial
from pathlib import Path

import cv2

from cable_tracker.campaigns.result_store import STORE, campaign_folder
from cable_tracker.campaigns.runner import run_all
from cable_tracker.campaigns.settings import ClusterSettings
from cable_tracker.commands.console.machine import origin_note
from cable_tracker.commands.console.terminal import (
    advance,
    console,
    messages,
    print_files,
    progress_bar,
)
from cable_tracker.commands.options.parameters import chosen_parameters
from cable_tracker.errors import ParameterError
from cable_tracker.evaluation.experiments.experiment import TABLE_MARKDOWN
from cable_tracker.evaluation.targets.comparison import (
    TargetCampaign,
    markdown_table,
    method_names,
    write_figures,
)
from cable_tracker.evaluation.targets.peers import MISSING_PEERS, PEERS
from cable_tracker.evaluation.targets.target_sequences import SimulatedTarget
from cable_tracker.followed_kinds import TARGET
from cable_tracker.simulation.targets.scenarios import TARGET_SCENARIOS
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.parameter_table import check_name

FIGURES_CSV = "figures.csv"
OWN_NAMES = frozenset({FIGURES_CSV, TABLE_MARKDOWN, STORE})
"""All that is ever written into the folder of an evaluation."""

FRAMES = 150

NOTHING = "nothing"
"""The scenario without any target, in which there is nothing to follow from a first box."""


def simulated_targets(names: Sequence[str], frames: int | None) -> tuple[SimulatedTarget, ...]:
    """Return scenarios by name or pattern, each once; all with a target if no name is given.

    Raises
    ------
    ParameterError
        There is no such scenario, or it has no target.
    """
    with_target = [name for name in TARGET_SCENARIOS if name != NOTHING]
    chosen: dict[str, SimulatedTarget] = {}
    for pattern in names or ["*"]:
        found = matching(with_target, pattern)
        if not found:
            raise ParameterError(f"scenario: {pattern!r} is none of {' | '.join(with_target)}")
        chosen |= {name: SimulatedTarget(name, frames or FRAMES) for name in found}
    return tuple(chosen.values())


def tuned_targets(files: Sequence[Path] | None) -> tuple[tuple[str, TargetParameters], ...]:
    """Return the parameters of files, each under the name of its file.

    Raises
    ------
    ParameterError
        A file is not acceptable, or two have the same name, or that of a method.
    """
    tuned: dict[str, TargetParameters] = {}
    for file in files or ():
        name = file.stem
        if name in tuned or name in method_names():
            raise ParameterError(f"params: there are two methods {name!r}; rename {file}")
        _, tuned[name] = chosen_parameters(TARGET, None, file, {}, None)
    return tuple(tuned.items())


def chosen_methods(
    names: Sequence[str] | None, tuned: Sequence[tuple[str, TargetParameters]]
) -> tuple[str, ...]:
    """Return the methods to judge: those that are named, or else the usual ones.

    Raises
    ------
    ParameterError
        There is no such method.
    """
    own = [name for name, _ in tuned]
    if not names:
        return ("default", *own) if own else ("default", "thesis", *PEERS, "grey default")
    for name in names:
        check_name("method", name, method_names())
    return (*dict.fromkeys(names), *own)


def evaluate_targets(
    campaign: TargetCampaign, output: Path, cluster: ClusterSettings, *, force: bool, resume: bool
) -> None:
    """Follow, judge, and write the tables into a folder."""
    missing = _missing_peers_message()
    if missing:
        messages.print(missing, style="bold yellow", soft_wrap=True)
    total = campaign.frame_count()
    with campaign_folder(
        output,
        TABLE_MARKDOWN,
        cluster,
        force=force,
        resume=resume,
        is_own_name=OWN_NAMES.__contains__,
    ) as (folder, settings):
        with progress_bar("following", total) as progress:
            runs = run_all(campaign.parts(), settings, advance=partial(advance, progress))
        results = [each for figures in runs for each in figures]
        note = f"{origin_note()} {missing}".rstrip()
        # Names of recordings need not be UTF-8; the table is, in its file and where it is printed.
        table = markdown_table(results, campaign.methods, note).encode(errors="replace").decode()
        write_figures(folder / FIGURES_CSV, results)
        (folder / TABLE_MARKDOWN).write_text(table, encoding="utf-8")
    console.print(table)
    print_files(output, (FIGURES_CSV, TABLE_MARKDOWN))


def _missing_peers_message() -> str:
    """Say which peers this OpenCV has not, and how to have them; empty where it has all."""
    if not MISSING_PEERS:
        return ""
    return (
        f"NOT COMPARED WITH {' AND '.join(MISSING_PEERS)}: OpenCV {cv2.__version__} has none."
        " Install 'opencv-contrib-python-headless<5' in place of opencv-python-headless, in a"
        " virtual environment of its own."
    )
