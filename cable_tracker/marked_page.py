"""Pages of text with a part between two marks that is written by a program."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from cable_tracker.atomic_output import write_bytes
from cable_tracker.errors import OutputError


class MarkedPage(NamedTuple):
    """Text of a page in three parts.

    Attributes
    ----------
    before : str
        Text up to the first mark, and the mark.
    content : str
        Text between the marks.
    after : str
        The second mark, and the text from there on.
    """

    before: str
    content: str
    after: str

    def write(self, path: Path, content: str) -> None:
        """Write the page with other text between the marks.

        Raises
        ------
        OutputError
            The page cannot be written.
        """
        write_bytes(path, f"{self.before}{content}{self.after}".encode())


def read_marked_page(path: Path, begin: str, end: str) -> MarkedPage:
    """Read a page and divide it at the first pair of its marks.

    Parameters
    ----------
    path : Path
        The page, a text in UTF-8.
    begin, end : str
        The marks.

    Raises
    ------
    OutputError
        The page cannot be read, or the marks are not in it in this order.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise OutputError(f"{path}: cannot be read as a page; choose another name") from error
    before, first, rest = text.partition(begin)
    content, second, after = rest.partition(end)
    if not (first and second):
        raise OutputError(
            f"{path}: has no place for the tables; add the lines {begin} and {end}, or choose"
            " another name"
        )
    return MarkedPage(before + begin, content, end + after)
