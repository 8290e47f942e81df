"""Names of files as text that can be printed, sent to a browser, and written as UTF-8."""

from __future__ import annotations

import os
from pathlib import Path


def printable(name: str | Path) -> str:
    r"""Return a name, or a message that holds one, with bytes that are no UTF-8 as ``\xe9``.

    Python keeps such bytes of a file name as halves of characters, which no encoder takes.
    """
    return os.fsencode(name).decode("utf-8", "backslashreplace")
