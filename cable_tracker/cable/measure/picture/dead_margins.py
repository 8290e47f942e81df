"""Margins that show nothing: the bars that a player or a recorder puts about a picture."""

from __future__ import annotations

import numpy as np

from cable_tracker.arrays import Image

FLAT = 3.0
"""Grey levels as near as this are one."""

BRIGHTEST = 24
"""Bars are black: a flat bottom beside a strip is none [grey levels]."""

PLAIN_SHARE, CAPTIONED_SHARE = 0.9, 0.5
"""Minimum share of one grey level in plain lines of a margin, and in those on which captions are
written, or that compression has changed beside them."""

FEWEST_PLAIN_LINES = 2
"""Margins with fewer plain lines are left."""

LARGEST_SHARE = 0.25
"""What is flat beyond this share of the picture, from one side, is no margin but the scene."""

BESIDE = 2
"""Lines beside a margin that compression and scaling have blurred into it."""


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
    if np.count_nonzero(outermost <= BRIGHTEST) < PLAIN_SHARE * len(outermost):
        return 0
    most, level = int(LARGEST_SHARE * len(lines)), float(np.median(outermost))
    count, plain = 0, 0
    while count <= most:
        apart = np.abs(lines[count].astype(np.float32) - level)
        of_one_level = np.count_nonzero(apart <= FLAT)
        if of_one_level < CAPTIONED_SHARE * lines.shape[1]:
            break
        count += 1
        plain += of_one_level >= PLAIN_SHARE * lines.shape[1]
    return count + BESIDE if plain >= FEWEST_PLAIN_LINES and count <= most else 0
