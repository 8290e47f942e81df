"""Paths that a user types on a page."""

from __future__ import annotations

from pathlib import Path

from cable_tracker.errors import GuiError


def typed_path(text: str) -> Path:
    """Return the path on the server; ``~`` is the home folder there.

    Raises
    ------
    GuiError
        Nothing is typed, or it names the home folder of a user that the server does not know.
    """
    if not text.strip():
        # As a path it would be the folder that the server was started in.
        raise GuiError("no path is given; type one")
    try:
        return Path(text.strip()).expanduser()
    except RuntimeError as error:
        raise GuiError(f"{text.strip()}: no such home folder; write the whole path") from error
