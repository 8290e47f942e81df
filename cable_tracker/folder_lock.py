"""A folder that one process has for itself, as long as it lives.

The lock lies on the folder, so that it leaves nothing, and the kernel takes it away with the
process. File systems that know no such locks let every process in.
"""

from __future__ import annotations

import fcntl
import os
from pathlib import Path
from weakref import WeakSet, finalize

_ATTEMPTS = 10
"""Other processes may remove and make the folder while it is being locked, but not for ever."""


class FolderLock:
    """A lock on a folder, until it is released or the process ends.

    A process that is forked meanwhile does not share it.

    Parameters
    ----------
    path : Path
        The folder; it is made, with those above it, if it is not there.

    Raises
    ------
    BlockingIOError
        Another process has the lock.
    OSError
        The folder cannot be made.
    """

    def __init__(self, path: Path) -> None:
        descriptor = _locked(path)
        self._close = None if descriptor is None else finalize(self, os.close, descriptor)
        _locks.add(self)

    def release(self) -> None:
        """Let others in."""
        if self._close is not None:
            self._close()


_locks: WeakSet[FolderLock] = WeakSet()


def _release_in_child() -> None:
    """Close the descriptors that a forked process has inherited: with them it would hold locks."""
    for lock in tuple(_locks):
        lock.release()


os.register_at_fork(after_in_child=_release_in_child)


def _locked(path: Path) -> int | None:
    """Return the descriptor of a folder with a lock on it; None: there are no locks."""
    for _ in range(_ATTEMPTS):
        path.mkdir(parents=True, exist_ok=True)
        try:
            descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
        except FileNotFoundError:
            continue
        except OSError:
            return None
        try:
            if _lock(descriptor, path):
                return descriptor
        except BlockingIOError:
            os.close(descriptor)
            raise
        except OSError:
            # The file system refuses locks.
            os.close(descriptor)
            return None
        os.close(descriptor)
    return None


def _lock(descriptor: int, path: Path) -> bool:
    """Lock an open folder; tell whether it still is the one that lies at its path."""
    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False
