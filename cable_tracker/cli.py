"""The command `cable-tracker`: its commands put together."""

from __future__ import annotations

import codecs
import io
import sys
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated

import typer

from cable_tracker import __version__
from cable_tracker.commands.console.lazy_group import LazyGroup, ListedCommand, with_optional_hints
from cable_tracker.commands.console.stop_signals import Stopped, StopSignals
from cable_tracker.errors import EXIT_USER_ERROR, CableTrackerError
from cable_tracker.printable import encodable

GROUPS: Mapping[str, Mapping[str, ListedCommand]] = MappingProxyType(
    {
        "Follow a cable, or a target with an outline": {
            "track": ("track:track", "Track a recording and write the results into a folder."),
            "target": (
                "target:target",
                "Follow a target with an outline: a buoy, a vehicle, a diver.",
            ),
            "gui": ("gui:gui", "Watch and tune the filter in a browser."),
        },
        "Fit the tracker to footage of yours": {
            "label": ("label:label", "Label a recording by hand, in a browser."),
            "learn": ("learn:learn", "Learn response tables from labelled recordings."),
            "evaluate": (
                "evaluate:evaluate",
                "Judge methods against ground truth and write a report.",
            ),
            "parameters": (
                "parameters:parameters",
                "Print all parameters, or write them to a file.",
            ),
        },
        "Map cables from dives": {
            "survey": (
                "survey:survey",
                "Map the cable from dives: its route, events, and a report.",
            ),
        },
        "Work with recordings": {
            "convert": ("convert:convert", "Convert any recording into a ROS 2 bag."),
            "simulate": (
                "simulate:simulate_command",
                "Simulate a cable or a target, with exact ground truth.",
            ),
        },
        "Steer by cable or target, and prepare a vehicle's computer": {
            "loop": ("loop:loop", "Let a simulated vehicle follow a cable, over ROS."),
            "chase": ("chase:chase", "Let a simulated vehicle follow a moving target over DDS."),
            "warm-up": ("warm_up:warm_up_command", "Compile beforehand what the trackers need."),
            "dds-profile": (
                "dds_profile:dds_profile",
                "Print the path of the Fast DDS profile for one machine.",
            ),
        },
        "Develop the package": {
            "dev": ("dev:app", "Experiments, benchmarks and endurance tests."),
        },
    }
)
"""Commands by task, in the order of the help."""

IN_ANY_LOCALE = "cable_tracker.in_any_locale"
"""Name under which Python knows `encodable`."""

FORMER_NAMES: Mapping[str, str] = MappingProxyType(
    {
        "experiment": "dev.experiment:experiment",
        "bench": "dev.bench:bench",
        "soak": "dev.soak:soak",
        "estimate-noise": "dev.estimate_noise:estimate_noise",
    }
)
"""Commands that stand under `dev` now; these names are not listed and go with the next release."""


class Commands(LazyGroup):
    """The commands of `cable-tracker`."""

    groups = GROUPS
    former_names = FORMER_NAMES


app = typer.Typer(
    name="cable-tracker",
    cls=Commands,
    help="Follow an underwater cable or pipeline by camera, with a particle filter.",
    no_args_is_help=True,
    rich_markup_mode=None,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def show_version(wanted: bool) -> None:
    """Print the version and end."""
    if wanted:
        typer.echo(f"cable-tracker {__version__}")
        raise typer.Exit


@app.callback()
@with_optional_hints
def root(
    version: Annotated[
        bool,
        typer.Option("--version", callback=show_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    """Follow an underwater cable or pipeline by camera, with a particle filter."""


def _print_message(text: str, style: str | None = None) -> None:
    """Print a message on stderr; the console is imported here, for most commands say nothing."""
    from cable_tracker.commands.console.terminal import messages  # noqa: PLC0415

    messages.print(text, style=style, soft_wrap=True)


def _print_in_any_locale() -> None:
    """Print names of files byte for byte, as `ls` does, and what a locale lacks as numbers."""
    codecs.register_error(IN_ANY_LOCALE, encodable)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors=IN_ANY_LOCALE)


def main() -> None:
    """Run the command; a user's error is one line and exit code 2.

    A signal unwinds the command like an exception, so that the nodes it has started are stopped and
    what it has half written is removed.
    """
    signals = StopSignals()
    signals.install()
    _print_in_any_locale()
    try:
        app()
    except CableTrackerError as error:
        notes = getattr(error, "__notes__", ())
        _print_message("; ".join([f"error: {error}", *notes]), style="bold red")
        sys.exit(EXIT_USER_ERROR)
    except Stopped as stopped:
        signals.arrived()
        kept = "; ".join(getattr(stopped, "__notes__", ()))
        _print_message(f"stopped; {kept or 'nothing was written'}")
        sys.exit(stopped.exit_code)


if __name__ == "__main__":
    main()
