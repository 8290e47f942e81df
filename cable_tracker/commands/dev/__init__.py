"""The commands of `cable-tracker dev`, for those who develop the package."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import typer

from cable_tracker.commands.console.lazy_group import LazyGroup, ListedCommand

GROUPS: Mapping[str, Mapping[str, ListedCommand]] = MappingProxyType(
    {
        "Measure": {
            "experiment": (
                "dev.experiment:experiment",
                "Run an experiment and write its tables and figures.",
            ),
            "bench": ("dev.bench:bench", "Measure how long frames take, beside a yardstick."),
            "estimate-noise": (
                "dev.estimate_noise:estimate_noise",
                "Print how much the cable moves from frame to frame.",
            ),
        },
        "Put under stress": {
            "soak": ("dev.soak:soak", "Feed a tracker for a long time, with faults."),
        },
    }
)


class DevCommands(LazyGroup):
    """The commands of `cable-tracker dev`."""

    groups = GROUPS


app = typer.Typer(
    name="dev",
    cls=DevCommands,
    help="Experiments, benchmarks and endurance tests.",
    no_args_is_help=True,
    rich_markup_mode=None,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback()
def dev() -> None:
    """Experiments, benchmarks and endurance tests."""
