"""The command `cable-tracker`: its commands put together."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from importlib import import_module
from types import FrameType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import typer
from typer.core import TyperGroup

from cable_tracker import __version__
from cable_tracker.errors import EXIT_USER_ERROR, CableTrackerError

COMMANDS = {
    "track": "track:track",
    "gui": "gui:gui",
    "convert": "convert:convert",
    "simulate": "simulate:simulate_command",
    "loop": "loop:loop",
    "label": "label:label",
    "evaluate": "evaluate:evaluate",
    "experiment": "experiment:experiment",
    "bench": "bench:bench",
    "estimate-noise": "estimate_noise:estimate_noise",
    "learn": "learn:learn",
    "soak": "soak:soak",
    "parameters": "parameters:parameters",
    "dds-profile": "dds_profile:dds_profile",
    "warm-up": "warm_up:warm_up_command",
}
"""Module of `cable_tracker.commands` and function of every command, in the order of the help."""


def _optional(hint: Any) -> Any:  # noqa: ANN401
    """Return a type hint with `Union` where it has `|`."""
    if get_origin(hint) is Annotated:
        return Annotated[(_optional(hint.__origin__), *hint.__metadata__)]
    if get_origin(hint) is UnionType:
        return Union[get_args(hint)]  # noqa: UP007
    return hint


def with_optional_hints(function: Callable[..., None]) -> Callable[..., None]:
    """Give a command type hints that Typer 0.9 reads: it refuses `str | None` (`X | Y`)."""
    hints = get_type_hints(function, include_extras=True)
    function.__annotations__ = {name: _optional(hint) for name, hint in hints.items()}
    return function


class LateCommands(TyperGroup):
    """Commands whose modules are imported when they are called, or listed with their help."""

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ANN401
        """Return the names of all commands."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ANN401
        """Return a command, or None where there is none of this name."""
        if cmd_name not in COMMANDS:
            return None
        module, function = COMMANDS[cmd_name].split(":")
        run = getattr(import_module(f"cable_tracker.commands.{module}"), function)
        single = typer.Typer(rich_markup_mode=None, add_completion=False)
        single.command(name=cmd_name)(with_optional_hints(run))
        return typer.main.get_command(single)


app = typer.Typer(
    name="cable-tracker",
    cls=LateCommands,
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
def root(
    version: Annotated[
        bool,
        typer.Option("--version", callback=show_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    """Follow an underwater cable or pipeline by camera, with a particle filter."""


class Stopped(BaseException):
    """SIGINT or SIGTERM has come. No `Exception`: nothing must take it for an error of its own."""

    def __init__(self, signal_number: int) -> None:
        super().__init__(signal_number)
        self.exit_code = 128 + signal_number


def _stop(signal_number: int, _frame: FrameType | None) -> None:
    raise Stopped(signal_number)


def _say(text: str, style: str | None = None) -> None:
    """Print a message on stderr; the console is imported here, for most commands say nothing."""
    from cable_tracker.commands.terminal import messages  # noqa: PLC0415

    messages.print(text, style=style, soft_wrap=True)


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
        _say(f"error: {error}", style="bold red")
        sys.exit(EXIT_USER_ERROR)
    except Stopped as stopped:
        _say("stopped; nothing was written")
        sys.exit(stopped.exit_code)


if __name__ == "__main__":
    main()
