"""Writing result files so that there is either a whole one or none."""

from __future__ import annotations

from pathlib import Path

from cable_tracker.errors import write_failure


def temporary_path(path: Path) -> Path:
    """Return the name that a file has while it is being written, in the same folder."""
    return path.with_name(f".{path.name}.part")


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file under a temporary name and rename it.

    Raises
    ------
    OutputError
        The file cannot be written; nothing is left behind.
    """
    part = temporary_path(path)
    try:
        try:
            part.write_bytes(content)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        raise write_failure(path, error) from error
