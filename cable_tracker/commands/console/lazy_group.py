"""Click group whose commands are imported when they are called."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from textwrap import shorten
from types import MappingProxyType, UnionType
from typing import Annotated, Any, ClassVar, TypeAlias, Union, get_args, get_origin, get_type_hints

import typer
from typer.core import TyperGroup

from cable_tracker.errors import ResourceError

NONE: Mapping[str, Any] = MappingProxyType({})

PACKAGE = "cable_tracker.commands"
"""Where the modules of commands lie."""

ListedCommand: TypeAlias = tuple[str, str]
"""Where a command lies, "module:function", the module below `PACKAGE`; instead of a function a
`typer.Typer` with further commands. Then its line of the help: importing all of them takes
seconds."""


class LazyGroup(TyperGroup):
    """A group of commands, listed by task.

    Attributes
    ----------
    groups : mapping of str to mapping of str to ListedCommand
        Title of a part of the help -> name of a command -> the command.
    former_names : mapping of str to str
        Commands by names that work and are not listed.
    """

    groups: ClassVar[Mapping[str, Mapping[str, ListedCommand]]] = NONE
    former_names: ClassVar[Mapping[str, str]] = NONE

    def __init__(self, **attributes: Any) -> None:  # noqa: ANN401
        super().__init__(**attributes)
        # Only the names are used: for the advice after a mistyped one.
        self.commands: dict[str, Any] = dict.fromkeys(self.places())

    def places(self) -> dict[str, str]:
        """Return module and function of every listed command."""
        return {name: place for group in self.groups.values() for name, (place, _) in group.items()}

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ANN401
        """Return the names of all listed commands."""
        return list(self.places())

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ANN401
        """Return a command, or None where there is none of this name.

        Raises
        ------
        ResourceError
            A package that the command needs is missing or does not fit the others.
        """
        place = (self.places() | dict(self.former_names)).get(cmd_name)
        if place is None:
            return None
        try:
            return load_command(cmd_name, place)
        except ImportError as error:
            raise ResourceError(
                f"{cmd_name} cannot be used here: {error}; docs/dependencies.md says which"
                " packages fit"
            ) from error

    def format_help(self, ctx: Any, formatter: Any) -> None:  # noqa: ANN401
        """Write the help as plain text, which Typer 0.9 does for no group of its own."""
        self.format_usage(ctx, formatter)
        self.format_help_text(ctx, formatter)
        self.format_options(ctx, formatter)

    def format_commands(self, ctx: Any, formatter: Any) -> None:  # noqa: ANN401
        """Write one part of the help for each group."""
        widest = max(map(len, self.places()))
        for title, group in self.groups.items():
            rows = [
                (name.ljust(widest), shorten(summary, formatter.width - 6 - widest))
                for name, (_, summary) in group.items()
            ]
            with formatter.section(title):
                formatter.write_dl(rows)


def load_command(name: str, place: str) -> Any:  # noqa: ANN401
    """Import a command and return it in the form that Typer calls."""
    module, attribute = place.split(":")
    loaded = getattr(import_module(f"{PACKAGE}.{module}"), attribute)
    if not isinstance(loaded, typer.Typer):
        single = typer.Typer(rich_markup_mode=None, add_completion=False)
        single.command(name=name)(with_optional_hints(loaded))
        loaded = single
    return typer.main.get_command(loaded)


def with_optional_hints(function: Callable[..., None]) -> Callable[..., None]:
    """Give a command type hints that Typer 0.9 reads: it refuses `str | None` (`X | Y`)."""
    hints = get_type_hints(function, include_extras=True)
    function.__annotations__ = {name: _optional(hint) for name, hint in hints.items()}
    return function


def _optional(hint: Any) -> Any:  # noqa: ANN401
    """Return a type hint with `Union` where it has `|`."""
    if get_origin(hint) is Annotated:
        # Python 3.11.2 takes an `Annotated[...]` of one form for that of the other.
        return hint.copy_with((_optional(hint.__origin__),))
    if get_origin(hint) is UnionType:
        return Union[get_args(hint)]  # noqa: UP007
    return hint
