"""Names of files as FFmpeg takes them."""

from __future__ import annotations

import os
from pathlib import Path


def ffmpeg_name(path: Path) -> str:
    """Return a name under which FFmpeg finds a file.

    What stands before a colon it takes for a protocol, as in `http:`, unless a slash stands before
    it; recorders write times such as 12:30:00 into names.
    """
    return os.path.join(os.curdir, path)  # noqa: PTH118
