"""The commands of `cable-tracker dev`, for those who develop the package."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import typer

from cable_tracker.commands.console.lazy_group import LazyGroup

GROUPS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "Measure": {
            "experiment": "dev.experiment:experiment",
            "bench": "dev.bench:bench",
            "estimate-noise": "dev.estimate_noise:estimate_noise",
        },
        "Put under stress": {
            "soak": "dev.soak:soak",
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
