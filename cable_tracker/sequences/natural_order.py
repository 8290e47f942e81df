"""Sort file names as a person would: frame_9 before frame_10."""

from __future__ import annotations

import re
from pathlib import Path


def natural_key(path: Path) -> tuple[tuple[tuple[int, int, str], ...], str]:
    """Return a sort key by the file's name, in which runs of digits count as numbers."""
    parts = re.split(r"([0-9]+)", path.name)
    numbers = tuple(
        (0, int(part), "") if part.isdecimal() else (1, 0, part) for part in parts if part
    )
    return numbers, path.name
