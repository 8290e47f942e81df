"""The folder or file that a long computation ends up in."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from cable_tracker.errors import OutputError
from cable_tracker.sequences.output_folder import PartialOutput


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

    with output_file(path, is_ours, overwrite=overwrite) as folder:
        folder.mkdir()
        yield folder


@contextmanager
def output_file(path: Path, is_ours: Callable[[Path], bool], *, overwrite: bool) -> Iterator[Path]:
    """Give the name of a file to write, which appears at its path when the context ends well.

    Parameters
    ----------
    path : Path
        Where it is to appear.
    is_ours : callable
        Tells whether what lies there is of the same kind; nothing else is ever replaced.
    overwrite : bool
        Replace an earlier file of the kind.

    Raises
    ------
    OutputError
        The path is taken, or the disk does not let us write.
    """
    partial = PartialOutput(path, overwrite=overwrite, is_ours=is_ours)
    try:
        yield partial.content
        partial.commit()
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror})") from error
    finally:
        partial.discard()
