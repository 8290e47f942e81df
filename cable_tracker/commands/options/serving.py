"""Base of the commands that serve a page."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Annotated

import typer

from cable_tracker.commands.console.terminal import console, messages
from cable_tracker.errors import GuiError

if TYPE_CHECKING:  # NiceGUI may not be installed.
    from cable_tracker.gui.web.server import Listening

DEFAULT_PORT = 8080

HostOption = Annotated[
    str,
    typer.Option(
        help="Address to listen on. Any but this machine's own needs the token that is printed."
    ),
]
PortOption = Annotated[int, typer.Option(min=0, max=65535, help="Port; 0 for any free one.")]


def need_gui(name: str) -> ModuleType:
    """Return a module of `cable_tracker.gui`.

    Raises
    ------
    GuiError
        NiceGUI is not installed.
    """
    try:
        return import_module(f"cable_tracker.gui.{name}")
    except ModuleNotFoundError as error:
        raise GuiError(
            f"the pages need NiceGUI (no module {error.name}); run `pip install '.[gui]'` in the"
            " package's folder"
        ) from error


def announce(listening: Listening) -> None:
    """Say where the page is, and how to come there from another machine."""
    console.print(f"open {listening.url}", soft_wrap=True, highlight=False)
    if listening.token is None:
        line = f"from another machine: {listening.ssh_line()}"
        console.print(line, soft_wrap=True, highlight=False)
    else:
        messages.print(
            "warning: the page can be reached from other machines, and what it says is not"
            " encrypted; everyone with the address and its token can command the tracker",
            soft_wrap=True,
        )
    console.print("stop with Ctrl-C")
