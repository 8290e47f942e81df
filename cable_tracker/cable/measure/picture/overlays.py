"""What players, recorders and survey displays lay over a picture: black bars, and thin lines.

The bars about a picture are filled by the nearest line that shows the scene.

A crosshair, a scale bar or a frame is as straight as a cable, longer and clearer. It is told from a
cable by three things: it stands still to the pixel while the ground moves, it is thinner than any
cable, and it runs along rows or columns. Lines with all three are removed.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from cable_tracker.arrays import BoolArray, Image
from cable_tracker.compilation import (
    compiled,
    compiled_inside,
    compiled_loop,
)

FLAT = 3.0
"""Grey levels as near as this are one."""

BRIGHTEST = 24
"""Bars are black: a flat bottom beside a strip is none [grey levels]."""

BLACK_SHARE = 0.9
"""Minimum share of black in the outermost line of a margin."""

PLAIN_SHARE, CAPTIONED_SHARE = 0.8, 0.5
"""Minimum share of one grey level, or darker ones, in plain lines of a margin, and in those on
which captions are written. Compression changes some pixels of plain lines beside a caption."""

FEWEST_PLAIN_LINES = 2
"""Margins with fewer plain lines are left."""

LARGEST_SHARE = 0.25
"""What is flat beyond this share of the picture, from one side, is no margin but the scene."""

BESIDE, BLOCK = 2, 8
"""Lines beside a margin that scaling has blurred into it, and the most into which compression has
carried its end: it works on blocks of so many."""

ABRUPT = 0.3
"""By how much the share of the margin's grey level falls at least where a bar ends. Towards the
dark about the cone of a lamp it changes line by line, and that is the scene."""

LEAST_HEIGHT = 8.0
"""Minimum difference of a thin line from both pixels beside it [grey levels]."""

THICKNESS = 2
"""Thickness of the thickest line [px at the reference width]: half that of the thinnest cable."""

THINNEST = 2
"""Minimum thickness in pixels of the picture: in narrower pictures no lines are looked for."""

LEAST_LENGTH = 40
"""Length of the shortest line, along a row or a column [px at the reference width]."""

SPACING, FEWEST_ROWS = 4, 5
"""Lines down the picture are looked for on every so many rows, those across it on columns
[px], and the shortest line crosses so many of them at least."""

LONGEST_GAP = 2
"""Longest gap in a line [rows or columns that are looked at]: a mark on it is not thin."""

LONGEST_TIME = 2.5
"""Upper bound of the counted time [s]."""

LONGEST_STEP = 0.04
"""Upper bound of the time that one frame adds [s]: at low frame rates as many frames are needed."""

MOST_COVERED = 0.04
"""Largest share of pixels on such lines: with more, the whole picture stands still."""

JUST_SEEN = 1e-6
"""Time of a pixel in the first picture in which it is on a line [s]; 0: it is on none."""

LOSS = 2.0
"""Factor by which a time falls faster than it grows, while no line is seen at the pixel."""


def without_dead_margins(frame: Image) -> Image:
    """Return a frame (H, W) with dead margins filled by the nearest live line.

    A bar's edge is longer and clearer than a cable's, but it is not in the scene. The frame itself
    is returned where it has no dead margin.
    """
    height, width = frame.shape
    top, bottom = dead_lines(frame), dead_lines(frame[::-1])
    left, right = dead_lines(frame.T), dead_lines(frame.T[::-1])
    if not (top or bottom or left or right):
        return frame
    filled = np.array(frame)
    filled[:top] = filled[top]
    filled[height - bottom :] = filled[height - bottom - 1]
    filled[:, :left] = filled[:, left : left + 1]
    filled[:, width - right :] = filled[:, width - right - 1 : width - right]
    return filled


def dead_lines(lines: Image) -> int:
    """Return how many of the first lines (L, n) are to be filled."""
    outermost = lines[0]
    if np.count_nonzero(outermost <= BRIGHTEST) < BLACK_SHARE * len(outermost):
        return 0
    most, level = int(LARGEST_SHARE * len(lines)), float(np.median(outermost))
    # What is darker than the margin is the box of a caption.
    dark = lines[: most + BLOCK + BESIDE + 1] <= level + FLAT
    shares = np.count_nonzero(dark, axis=1) / lines.shape[1]
    count = int(np.argmax(np.append(shares, 0.0) < CAPTIONED_SHARE))
    plain = np.count_nonzero(shares[:count] >= PLAIN_SHARE)
    if plain < FEWEST_PLAIN_LINES or count > most:
        return 0
    end = count + _compressed_lines(lines[count : count + BLOCK + 1], level)
    falls = shares[count - 1 : end] - shares[count - 1 + BESIDE : end + BESIDE]
    return end + BESIDE if (falls >= ABRUPT).any() else 0


def _compressed_lines(lines: Image, level: float) -> int:
    """Return how many of the lines (K, n) at a margin's end are nearer to its level than the last.

    Compression leaves them unlike the margin, yet darker than the scene beside it.
    """
    middle = (level + float(np.median(lines[-1]))) / 2.0
    shares = np.count_nonzero(lines <= middle, axis=1) / lines.shape[1]
    return int(np.argmax(shares < CAPTIONED_SHARE))


@dataclass(frozen=True, slots=True, eq=False)
class StandingLines:
    """For how long pixels have been on a thin line.

    Attributes
    ----------
    down : Image
        On one that runs down the picture, float32, shape (2, rows, w) [s]: on one that is brighter
        than what is beside it, and on a darker one. Rows are `SPACING` px apart.
    across : Image
        On one that runs across it, shape (2, columns, h); columns are `SPACING` px apart.
    scale : float
        Pixels of the picture per pixel of one of the reference width.
    thickness : int
        Thickness of the thickest line [px].
    """

    down: Image
    across: Image
    scale: float
    thickness: int


def standing_lines(
    before: StandingLines | None, picture: Image, dt: float, scale: float
) -> StandingLines | None:
    """Return for how long the pixels of a picture have been on thin lines.

    None for a picture that is too narrow to tell a line from the thinnest cable.

    Parameters
    ----------
    before : StandingLines or None
        Those of the picture before; None, or of another size: this is the first one.
    picture : Image
        Grey levels, uint8 or float32, shape (h, w).
    dt : float
        Time since the picture before [s].
    scale : float
        Pixels of the picture per pixel of one of the reference width.
    """
    thickness = round(THICKNESS * scale)
    if thickness < THINNEST:
        return None
    rows = picture[::SPACING].astype(np.float32)
    columns = np.ascontiguousarray(picture[:, ::SPACING].T).astype(np.float32)
    if before is None or before.down.shape[1:] != rows.shape:
        down = np.zeros((2, *rows.shape), np.float32)
        across = np.zeros((2, *columns.shape), np.float32)
    else:
        down, across = before.down.copy(), before.across.copy()
    _add_times(rows, columns, thickness, min(dt, LONGEST_STEP), down, across)
    return StandingLines(down, across, scale, thickness)


def without_standing_lines(picture: Image, lines: StandingLines, least_time: float) -> Image:
    """Return a picture without the lines that have stood still for long enough.

    Parameters
    ----------
    picture : Image
        Grey levels, uint8 or float32, shape (h, w). It is returned itself if no line is taken out.
    lines : StandingLines
        For how long its pixels have been on thin lines.
    least_time : float
        Lines that have stood still for this time are taken out [s].
    """
    least = np.float32(least_time)
    # Odd, for OpenCV shifts what it opens with an even number of rows.
    length = max(round(LEAST_LENGTH * lines.scale) // SPACING, FEWEST_ROWS) | 1
    down, across = lines.down >= least, lines.across >= least
    # No line is long enough where no column, or row, has so many pixels on lines of one kind.
    most = max(down.sum(axis=1).max(), across.sum(axis=1).max())
    if most < length // (LONGEST_GAP + 1):
        return picture
    long_down, long_across = (
        [_long(is_on_line, length) for is_on_line in kinds] for kinds in (down, across)
    )
    if not any(kind.any() for kind in (*long_down, *long_across)):
        return picture
    bright, dark = (
        _whole(kind_down, picture.shape) | _whole(kind_across, picture.shape[::-1]).T
        for kind_down, kind_across in zip(long_down, long_across, strict=True)
    )
    if np.count_nonzero(bright | dark) > MOST_COVERED * picture.size:
        return picture
    side = lines.thickness | 1
    neighbourhood = cv2.getStructuringElement(cv2.MORPH_RECT, (side, side))
    without_bright = cv2.morphologyEx(picture, cv2.MORPH_OPEN, neighbourhood)
    without_dark = cv2.morphologyEx(picture, cv2.MORPH_CLOSE, neighbourhood)
    return np.asarray(np.where(dark, without_dark, np.where(bright, without_bright, picture)))


@compiled
def _add_times(
    rows: Image, columns: Image, reach: int, step: float, down: Image, across: Image
) -> None:
    """Add a step to the times of both families, see `_add_time`."""
    _add_time(rows, reach, step, down)
    _add_time(columns, reach, step, across)


@compiled_loop
def _add_time(levels: Image, reach: int, step: float, times: Image) -> None:
    """Add a step to the times (2, n, m) of pixels on a thin line, and take it from the others'.

    Such a pixel of `levels` (n, m) stands out from those `reach` before and behind it.
    """
    least, gain, loss = np.float32(LEAST_HEIGHT), np.float32(step), np.float32(LOSS * step)
    for row in range(len(levels)):
        line = levels[row]
        before, here, behind = line[: -2 * reach], line[reach:-reach], line[2 * reach :]
        bright, dark = times[0, row, reach:-reach], times[1, row, reach:-reach]
        for place in range(len(here)):
            rise = here[place] - max(before[place], behind[place])
            fall = min(before[place], behind[place]) - here[place]
            bright[place] = _time_after(bright[place], rise >= least, gain, loss)
            dark[place] = _time_after(dark[place], fall >= least, gain, loss)


@compiled_inside
def _time_after(time: np.float32, is_line: bool, gain: np.float32, loss: np.float32) -> np.float32:
    """Return the time of a pixel after one more picture [s]."""
    grown, shrunk = time + gain, time - loss
    grown = grown if grown < LONGEST_TIME else np.float32(LONGEST_TIME)
    grown = grown if time > 0.0 else np.float32(JUST_SEEN)
    shrunk = shrunk if shrunk > 0.0 else np.float32(0.0)
    return grown if is_line else shrunk


def _long(mask: BoolArray, length: int) -> BoolArray:
    """Return where a mask (n, m) is set on so many rows, one after the other but for short gaps."""
    closed = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, _rows(LONGEST_GAP + 1))
    # What lies beyond the picture is no line.
    border = cv2.BORDER_CONSTANT
    opened = cv2.morphologyEx(
        closed, cv2.MORPH_OPEN, _rows(length), borderType=border, borderValue=0.0
    )
    return np.asarray(opened > 0)


def _rows(count: int) -> Image:
    """Return so many pixels, one below the other."""
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_RECT, (1, count)))


def _whole(mask: BoolArray, shape: tuple[int, ...]) -> BoolArray:
    """Return a mask of rows `SPACING` px apart for all rows of a picture."""
    return np.repeat(mask, SPACING, axis=0)[: shape[0]]
