"""Where targets are at the start, as a parameter says it."""

from __future__ import annotations

from dataclasses import dataclass

from cable_tracker.errors import FrameError, ParameterError
from cable_tracker.target.model.start import TargetStart

WAIT, DETECT = "wait", "detect"
"""Words for a start where a mark is waited for, and where a detector proposes."""


@dataclass(frozen=True, slots=True)
class StartText:
    """What such a text says.

    Attributes
    ----------
    detects : bool
        Whether a detector is asked for.
    boxes : tuple of TargetStart
        Marked targets, the first first; empty where none is marked.
    """

    detects: bool
    boxes: tuple[TargetStart, ...]


def parse_start_text(text: str) -> StartText:
    """Read `wait`, `detect`, or boxes `x0,y0,x1,y1` in px from the top left, divided by `;`.

    Raises
    ------
    ParameterError
        It is none of these, or a box has no area.
    """
    word = text.strip()
    if word in {WAIT, DETECT}:
        return StartText(word == DETECT, ())
    try:
        return StartText(False, tuple(parse_box(part) for part in word.split(";")))
    except ParameterError as error:
        raise ParameterError(f"{error}; give {WAIT}, {DETECT}, or boxes divided by ';'") from error


def parse_box(text: str) -> TargetStart:
    """Read a box `x0,y0,x1,y1` in px from the top left.

    Raises
    ------
    ParameterError
        It is no box, or has no area.
    """
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 4:
        raise ParameterError(
            f"{text.strip()!r} is no box x0,y0,x1,y1 in px from the top left corner"
        )
    try:
        return TargetStart.from_box(*numbers)
    except FrameError as error:
        raise ParameterError(str(error)) from error
