"""Margins that show nothing: the bars that a player or a recorder puts about a picture."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import Image

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
