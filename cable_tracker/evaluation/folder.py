"""The folder that a long computation ends up in."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cable_tracker.errors import OutputError
from cable_tracker.sequences.output_folder import PartialFolder


@contextmanager
def output_folder(path: Path, marker: str, *, overwrite: bool) -> Iterator[Path]:
    """Give a folder to write into, which appears at its path when the context ends well.

    It is opened before anything is computed, so that a path that cannot be written is known at
    once.

    Parameters
    ----------
    path : Path
        Where it is to appear.
    marker : str
        A file that every such folder holds; a folder without it is never replaced.
    overwrite : bool
        Replace an earlier folder of the kind.

    Raises
    ------
    OutputError
        The path is taken, or the disk does not let us write.
    """

    def is_ours(folder: Path) -> bool:
        return folder.is_dir() and ((folder / marker).is_file() or not any(folder.iterdir()))

    partial = PartialFolder(path, overwrite=overwrite, is_ours=is_ours)
    try:
        partial.content.mkdir()
        yield partial.content
        partial.commit()
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror})") from error
    finally:
        partial.discard()
