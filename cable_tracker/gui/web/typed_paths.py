"""Paths that a user types on a page."""

from __future__ import annotations

from pathlib import Path

from cable_tracker.errors import GuiError


def typed_path(text: str) -> Path:
    """Return the path on the server; ``~`` is the home folder there.

    Raises
    ------
    GuiError
        It names the home folder of a user that the server does not know.
    """
    try:
        return Path(text.strip()).expanduser()
    except RuntimeError as error:
        raise GuiError(f"{text.strip()}: no such home folder; write the whole path") from error
