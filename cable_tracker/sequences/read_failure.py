"""The error of a file that the system does not let us read."""

from __future__ import annotations

from pathlib import Path

from cable_tracker.errors import RecordingError


def read_failure(path: Path, error: OSError) -> RecordingError:
    """Return the error that says that a file or folder cannot be read, and why."""
    return RecordingError(f"{path}: cannot be read ({error.strerror}); check its permissions")
