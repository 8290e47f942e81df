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
    if np.count_nonzero(outermost <= BRIGHTEST) < PLAIN_SHARE * len(outermost):
        return 0
    most, level = int(LARGEST_SHARE * len(lines)), float(np.median(outermost))
    near = np.abs(lines[: most + 1 + BESIDE].astype(np.float32) - level) <= FLAT
    shares = np.count_nonzero(near, axis=1) / lines.shape[1]
    count = int(np.argmax(np.append(shares, 0.0) < CAPTIONED_SHARE))
    plain = np.count_nonzero(shares[:count] >= PLAIN_SHARE)
    if plain < FEWEST_PLAIN_LINES or count > most:
        return 0
    is_abrupt = shares[count - 1] - shares[count + BESIDE - 1] >= ABRUPT
    return count + BESIDE if is_abrupt else 0
