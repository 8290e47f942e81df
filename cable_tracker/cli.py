"""The command `cable-tracker`: its commands put together."""

from __future__ import annotations

import signal
import sys
from types import FrameType
from typing import Annotated

import typer

from cable_tracker import __version__
from cable_tracker.commands.bench import bench
from cable_tracker.commands.convert import convert
from cable_tracker.commands.dds_profile import dds_profile
from cable_tracker.commands.estimate_noise import estimate_noise
from cable_tracker.commands.evaluate import evaluate
from cable_tracker.commands.experiment import experiment
from cable_tracker.commands.gui import gui
from cable_tracker.commands.label import label
from cable_tracker.commands.learn import learn
from cable_tracker.commands.loop import loop
from cable_tracker.commands.parameters import parameters
from cable_tracker.commands.simulate import simulate_command
from cable_tracker.commands.soak import soak
from cable_tracker.commands.survey import survey
from cable_tracker.commands.terminal import console, messages
from cable_tracker.commands.track import track
from cable_tracker.commands.warm_up import warm_up_command
from cable_tracker.errors import EXIT_USER_ERROR, CableTrackerError

app = typer.Typer(
    name="cable-tracker",
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
        console.print(f"cable-tracker {__version__}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[
        bool,
        typer.Option("--version", callback=show_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    """Follow an underwater cable or pipeline by camera, with a particle filter."""


app.command()(track)
app.command()(gui)
app.command()(survey)
app.command()(convert)
app.command(name="simulate")(simulate_command)
app.command()(loop)
app.command()(label)
app.command()(evaluate)
app.command()(experiment)
app.command()(bench)
app.command()(estimate_noise)
app.command()(learn)
app.command()(soak)
app.command()(parameters)
app.command()(dds_profile)
app.command(name="warm-up")(warm_up_command)


class Stopped(BaseException):
    """SIGINT or SIGTERM has come. No `Exception`: nothing must take it for an error of its own."""

    def __init__(self, signal_number: int) -> None:
        super().__init__(signal_number)
        self.exit_code = 128 + signal_number


def _stop(signal_number: int, _frame: FrameType | None) -> None:
    raise Stopped(signal_number)


def main() -> None:
    """Run the command; a user's error is one line and exit code 2.

    A signal unwinds the command like an exception, so that the nodes it has started are stopped and
    what it has half written is removed.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _stop)
    try:
        app()
    except CableTrackerError as error:
        messages.print(f"error: {error}", style="bold red", soft_wrap=True)
        sys.exit(EXIT_USER_ERROR)
    except Stopped as stopped:
        messages.print("stopped; nothing was written")
        sys.exit(stopped.exit_code)


if __name__ == "__main__":
    main()
