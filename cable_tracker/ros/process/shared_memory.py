"""Removes shared memory that killed processes have left behind.

Fast DDS gives each process a segment in /dev/shm (32 MB with the shipped profile) and holds a lock
on a file beside it for as long as the process lives. A killed process removes neither, and they
would stay until the machine restarts.
"""

from __future__ import annotations

import fcntl
import os
import re
import time
from contextlib import suppress
from pathlib import Path

FOLDER = Path("/dev/shm")
LOCK_FILE = re.compile(r"(fastrtps_[0-9a-f]{16})_el")

YOUNGEST = 60.0
"""A lock file younger than this may belong to a process that is about to take the lock [s]."""


def remove_dead_segments() -> list[str]:
    """Remove the segments whose owner is dead; return their names.

    Those of other users are left alone, and so are those whose lock is held.
    """
    if not FOLDER.is_dir():
        return []
    removed = []
    for path in sorted(FOLDER.iterdir()):
        match = LOCK_FILE.fullmatch(path.name)
        if match is None:
            continue
        # Another process may be removing it at this moment.
        with suppress(OSError):
            if _is_ours_and_old(path) and _remove_if_unlocked(path, FOLDER / match[1]):
                removed.append(match[1])
    return removed


def _is_ours_and_old(path: Path) -> bool:
    status = path.stat()
    return status.st_uid == os.getuid() and time.time() - status.st_mtime >= YOUNGEST


def _remove_if_unlocked(lock_file: Path, segment: Path) -> bool:
    descriptor = os.open(lock_file, os.O_RDWR)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        segment.unlink(missing_ok=True)
        lock_file.unlink()
    except BlockingIOError:
        return False
    finally:
        os.close(descriptor)
    return True
