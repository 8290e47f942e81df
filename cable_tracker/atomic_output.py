"""Write a folder or a file in such a way that nothing half-written ever looks complete.

`PartialOutput` is for what a user names, a folder or a file, which must not replace anything else;
`AtomicFile` for single files inside, and for those that are written again and again.
"""

from __future__ import annotations

import glob
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from cable_tracker.errors import OutputError, write_failure
from cable_tracker.folder_lock import FolderLock


def _delete(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink()


def _write_through(path: Path) -> None:
    """Wait until a folder or a file is on the disk, not only in its cache.

    Otherwise a power cut can leave an empty file under the final name; and a disk that fails late
    would not be noticed.
    """
    for item in (path, *path.rglob("*")):
        descriptor = os.open(item, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def any_name(_name: str) -> bool:
    """Take every file of an earlier folder for one that was written with it."""
    return True


def _foreign_files(path: Path, is_own_name: Callable[[str], bool]) -> list[str]:
    """Return the names of what was put into a folder later, in order; hidden files do not count."""
    if path.is_symlink() or not path.is_dir():
        return []
    # Hidden files are those of file managers.
    names = (each.name for each in path.iterdir() if not each.name.startswith("."))
    return sorted(name for name in names if not is_own_name(name))


def _refuse_foreign_files(path: Path, is_own_name: Callable[[str], bool]) -> None:
    """Raise OutputError if a folder that is to be replaced holds what was put there later."""
    foreign = _foreign_files(path, is_own_name)
    if foreign:
        more = f" and {len(foreign) - 1} more" if len(foreign) > 1 else ""
        raise OutputError(
            f"{path / foreign[0]}{more}: would be lost with the earlier output and is not"
            " overwritten; move it elsewhere, or choose another name"
        )


def _is_being_written(path: Path) -> OutputError:
    return OutputError(
        f"{path}: another run is writing it; wait until that has ended, or choose another name"
    )


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder that is written piece by piece, and made if it is not there.

    Raises
    ------
    OutputError
        Another run is writing it, or it cannot be made.
    """
    try:
        lock = FolderLock(folder)
    except BlockingIOError as error:
        raise _is_being_written(folder) from error
    except OSError as error:
        raise write_failure(folder, error) from error
    try:
        yield
    finally:
        lock.release()


class PartialOutput:
    """A folder or a file that is made under another name and moved into place when complete.

    One run at a time may make it; what one that was killed has left is removed by the next.

    Parameters
    ----------
    path : Path
        Path at which it appears when it is complete.
    overwrite : bool
        Replace what lies there, once the new one is complete.
    is_ours : callable
        Tells whether what lies there is of the kind that is written here; nothing else is ever
        replaced.
    is_own_name : callable
        Tells by its name whether a file in an earlier folder was written with it. A folder with
        others, which the user has put there, is not replaced. Those that are put there while the
        new one is made are carried over into it.
    carries_over : bool
        Carry over also those that are there already, instead of refusing to replace the folder.

    Attributes
    ----------
    content : Path
        Path to write to until then. It does not exist yet; its parent does.

    Raises
    ------
    OutputError
        Something lies at the path and must not be replaced, another run is writing it, or the disk
        does not let us write.
    """

    def __init__(
        self,
        path: Path,
        *,
        overwrite: bool,
        is_ours: Callable[[Path], bool],
        is_own_name: Callable[[str], bool] = any_name,
        carries_over: bool = False,
    ) -> None:
        self._is_own_name = is_own_name
        if path.name in ("", ".."):
            raise OutputError(f"{path}: is no name for a new output; choose one")
        self.path = path
        self._partial = path.with_name(f".{path.name}.partial")
        self.content = self._partial / path.name
        if path.exists() or path.is_symlink():
            if not overwrite:
                raise OutputError(
                    f"{path}: exists already; choose another name, or overwrite it with --force"
                )
            if not is_ours(path):
                raise OutputError(
                    f"{path}: is no earlier output of this kind and is not overwritten;"
                    " choose another name"
                )
            if not carries_over:
                _refuse_foreign_files(path, is_own_name)
        self._lock: FolderLock | None = None
        try:
            self._take_partial()
        except BlockingIOError as error:
            raise _is_being_written(path) from error
        except OSError as error:
            self.discard()
            raise write_failure(path, error) from error
        except BaseException:
            # A signal may come as soon as the folder is there, before a caller can discard it.
            self.discard()
            raise

    def _take_partial(self) -> None:
        """Make the hidden folder, or empty the one that a run which did not end well has left."""
        is_new = not self._partial.is_dir()
        if self._partial.is_symlink() or (is_new and self._partial.exists()):
            self._partial.unlink()
        try:
            self._lock = FolderLock(self._partial)
        except OSError:
            raise
        except BaseException:
            if is_new:
                with suppress(OSError):
                    self._partial.rmdir()
            raise
        for left in self._partial.iterdir():
            _delete(left)

    def commit(self) -> None:
        """Move the content into place, and with it what the user has put there meanwhile.

        Raises
        ------
        OutputError
            It cannot be moved; then it is removed, and what lay there before is left.
        """
        replaced = self._partial / ".replaced"
        carried: list[tuple[Path, Path]] = []
        try:
            _write_through(self.content)
            if self.path.exists() or self.path.is_symlink():
                self.path.rename(replaced)
                self._carry_over(replaced, carried)
            self.content.rename(self.path)
        except BaseException as error:
            # A signal may come between the two, as well as an error.
            if replaced.exists() and not self.path.exists():
                for here, there in carried:
                    if there.exists() and not here.exists():
                        there.rename(here)
                replaced.rename(self.path)
            self.discard()
            if isinstance(error, OSError):
                raise write_failure(self.path, error) from error
            raise
        self.discard()

    def _carry_over(self, replaced: Path, carried: list[tuple[Path, Path]]) -> None:
        """Move files that are not of this output into the new folder, and note from where to where.

        Only here, once no name leads to the earlier folder any more, none can be added unseen.
        """
        for name in _foreign_files(replaced, self._is_own_name):
            place = self.content / name
            while place.exists():
                place = place.with_name(f"{place.name}.earlier")
            carried.append((replaced / name, place))
            (replaced / name).rename(place)

    def discard(self) -> None:
        """Remove the content, and let other runs write to the path."""
        if self._lock is None:
            # Another run may be writing by now.
            return
        shutil.rmtree(self._partial, ignore_errors=True)
        self._lock.release()
        self._lock = None


def holds(marker: str) -> Callable[[Path], bool]:
    """Return a test of whether a path is an empty folder, or one that holds a file of a name."""
    return lambda path: path.is_dir() and ((path / marker).is_file() or not any(path.iterdir()))


@contextmanager
def output_folder(
    path: Path, marker: str, *, overwrite: bool, is_own_name: Callable[[str], bool]
) -> Iterator[Path]:
    """Give a folder to write into, which appears at its path when the context ends well.

    It is opened before anything is computed, so that a path that cannot be written is known at
    once.

    Parameters
    ----------
    path : Path
        Path at which it appears when it is complete.
    marker : str
        A file that every such folder holds; a folder without it is never replaced.
    overwrite : bool
        Replace an earlier folder of the kind.
    is_own_name : callable
        See `PartialOutput`.

    Raises
    ------
    OutputError
        The path is taken, or the disk does not let us write.
    """
    with output_file(path, holds(marker), overwrite=overwrite, is_own_name=is_own_name) as folder:
        folder.mkdir()
        yield folder


@contextmanager
def output_file(
    path: Path,
    is_ours: Callable[[Path], bool],
    *,
    overwrite: bool,
    is_own_name: Callable[[str], bool] = any_name,
    carries_over: bool = False,
) -> Iterator[Path]:
    """Give the name of a file to write, which appears at its path when the context ends well.

    Parameters
    ----------
    path : Path
        Path at which it appears when it is complete.
    is_ours : callable
        Tells whether what lies there is of the same kind; nothing else is ever replaced.
    overwrite : bool
        Replace an earlier file of the kind.
    is_own_name, carries_over
        See `PartialOutput`; where it is a folder.

    Raises
    ------
    OutputError
        The path is taken, or the disk does not let us write.
    """
    partial = PartialOutput(
        path,
        overwrite=overwrite,
        is_ours=is_ours,
        is_own_name=is_own_name,
        carries_over=carries_over,
    )
    try:
        yield partial.content
        partial.commit()
    except OSError as error:
        raise write_failure(path, error) from error
    finally:
        partial.discard()


class AtomicFile:
    """A file that is written under another name and takes its place when it is complete.

    Parameters
    ----------
    path : Path
        Path of the file; an earlier file is replaced.
    by_many : bool
        Whether several processes may write it at the same time.

    Attributes
    ----------
    part : Path
        Path to write to until then: hidden, in the same folder, of the same suffix.
    """

    def __init__(self, path: Path, *, by_many: bool = False) -> None:
        self._path = path
        number = f".{os.getpid()}" if by_many else ""
        self.part = path.with_name(f".{path.stem}{number}.part{path.suffix}")

    def commit(self, *, waits: bool = False) -> None:
        """Move it into place.

        Parameters
        ----------
        waits : bool
            Whether to wait until it is on the disk, not only in its cache.

        Raises
        ------
        OSError
            It cannot be moved; what lay there is as it was.
        """
        if waits:
            _write_through(self.part)
        self.part.replace(self._path)

    def discard(self) -> None:
        """Remove what is left of it, and the journal that a database leaves beside it.

        Raises
        ------
        OSError
            It cannot be removed.
        """
        for left in self.part.parent.glob(f"{glob.escape(self.part.name)}*"):
            left.unlink(missing_ok=True)


@contextmanager
def atomic_file(path: Path, *, by_many: bool = False, waits: bool = False) -> Iterator[Path]:
    """Give the name of a file to write, which takes its place when the context ends well.

    Otherwise nothing is left of it, and what lay there is as it was; so it is where nothing was
    written.

    Parameters
    ----------
    path, by_many
        See `AtomicFile`.
    waits : bool
        Whether to wait until it is on the disk, not only in its cache.

    Raises
    ------
    OSError
        It cannot be written.
    """
    file = AtomicFile(path, by_many=by_many)
    try:
        yield file.part
        if file.part.exists():
            file.commit(waits=waits)
    finally:
        # Why it could not be written says more than why its rest cannot be removed.
        with suppress(OSError):
            file.discard()


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file of a result, in place of an earlier one.

    Raises
    ------
    OutputError
        The file cannot be written; nothing is left behind.
    """
    try:
        with atomic_file(path) as part:
            part.write_bytes(content)
    except OSError as error:
        raise write_failure(path, error) from error


def write_text(path: Path, text: str, *, waits: bool = True) -> None:
    """Write a text file, in place of an earlier one and with its permissions; see `atomic_file`.

    Parameters
    ----------
    path : Path
        Path to write to; a link is followed.
    waits : bool
        Whether to wait until it is on the disk, not only in its cache.

    Raises
    ------
    OSError
        It cannot be written; what lay there is as it was.
    """
    target = path.resolve()
    with atomic_file(target, by_many=True, waits=waits) as part:
        part.write_text(text, encoding="utf-8", newline="")
        if target.exists():
            part.chmod(target.stat().st_mode & 0o7777)
