"""Names of files as text that can be printed, sent to a browser, and written as UTF-8."""

from __future__ import annotations

import os
from pathlib import Path


def printable(name: str | Path) -> str:
    r"""Return a name, or a message that holds one, with bytes that are no UTF-8 as ``\xe9``.

    Python keeps such bytes of a file name as halves of characters, which no encoder takes.
    """
    return os.fsencode(name).decode("utf-8", "backslashreplace")


def encodable(error: UnicodeError) -> tuple[bytes, int]:
    r"""Encode what an encoding lacks: halves of characters as their byte, others as ``\u03b1``.

    It is an error handler of `codecs`: it returns the bytes, and where to go on.

    Raises
    ------
    UnicodeError
        It was raised by something else than encoding.
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    encoded = (
        letter.encode("ascii", "surrogateescape" if _is_byte(letter) else "backslashreplace")
        for letter in error.object[error.start : error.end]
    )
    return b"".join(encoded), error.end


def _is_byte(letter: str) -> bool:
    """Tell whether a letter is one of those that Python makes of bytes that it cannot decode."""
    return "\udc80" <= letter <= "\udcff"
