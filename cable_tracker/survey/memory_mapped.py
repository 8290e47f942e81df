"""Memory-mapped arrays, so that a process needs no more memory for a long dive than for a short.

An array has a row for each picture, pose or keyframe of a dive. It is a file without a name, mapped
into memory; the pages of a block of rows are released before the next block.
Functions here give bit for bit what those of NumPy give for a whole array.
"""

from __future__ import annotations

import math
import mmap
import os
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any
from weakref import WeakSet, finalize

import numpy as np
import numpy.typing as npt

from cable_tracker.arrays import BoolArray, FloatArray, IndexArray
from cable_tracker.errors import write_failure

BLOCK = 4096
"""Rows that are worked on together."""

AnyArray = npt.NDArray[Any]


@dataclass(frozen=True, slots=True, eq=False)
class Disk:
    """Allocator of memory-mapped arrays.

    They take no room when they are no longer used, nor after a process that was killed.

    Attributes
    ----------
    folder : Path
        Folder of the files.
    block : int
        Rows that are worked on together; arrays of not more rows stay in memory.
    """

    folder: Path = field(default_factory=lambda: Path(tempfile.gettempdir()))
    block: int = BLOCK
    _maps: WeakSet[mmap.mmap] = field(default_factory=WeakSet, repr=False)

    def array(self, shape: int | tuple[int, ...], dtype: npt.DTypeLike = np.float64) -> Any:  # noqa: ANN401
        """Return an array of zeros.

        Raises
        ------
        OutputError
            There is no room for it.
        """
        shape = (shape,) if isinstance(shape, int) else shape
        if shape[0] <= self.block:
            return np.zeros(shape, dtype)
        size = math.prod(shape) * np.dtype(dtype).itemsize
        try:
            with self.file() as file:
                os.posix_fallocate(file.fileno(), 0, size)
                return self.mapped(file, dtype).reshape(shape)
        except OSError as error:
            raise write_failure(self.folder, error) from error

    def file(self) -> IO[bytes]:
        """Open a file without a name."""
        return tempfile.TemporaryFile(dir=self.folder)

    def mapped(self, file: IO[bytes], dtype: npt.DTypeLike) -> AnyArray:
        """Return the content of a file as a writable array, shape (N,).

        Raises
        ------
        OutputError
            The folder's file system does not map files into memory.
        """
        try:
            mapping = mmap.mmap(file.fileno(), 0)
        except OSError as error:
            raise write_failure(self.folder, error) from error
        self._maps.add(mapping)
        return np.frombuffer(mapping, dtype)

    def release_pages(self) -> None:
        """Release the pages of all arrays from memory; what is used again is read again."""
        for mapping in tuple(self._maps):
            mapping.madvise(mmap.MADV_DONTNEED)

    def blocks(self, count: int, start: int = 0) -> Iterator[slice]:
        """Yield the blocks of rows from `start` up to `count`; pages of used ones are released."""
        for first in range(start, count, self.block):
            yield slice(first, min(first + self.block, count))
            self.release_pages()

    def blocks_reversed(self, count: int, start: int = 0) -> Iterator[slice]:
        """Yield the blocks of rows from the one before `count` back to `start`."""
        for last in range(count, start, -self.block):
            yield slice(max(last - self.block, start), last)
            self.release_pages()

    def filled(
        self, count: int, part: Callable[[slice], AnyArray], dtype: npt.DTypeLike = np.float64
    ) -> Any:  # noqa: ANN401
        """Return an array of `count` rows whose blocks a function gives, each (rows, ...)."""
        first = part(slice(0, min(self.block, count)))
        whole = self.array((count, *first.shape[1:]), dtype)
        whole[: len(first)] = first
        for rows in self.blocks(count, len(first)):
            whole[rows] = part(rows)
        return whole

    def median(self, values: FloatArray, kept: Callable[[slice], BoolArray]) -> float:
        """Return the median of those values (N,) that are kept, of which there is at least one."""
        chosen = self.growing(np.float64)
        for rows in self.blocks(len(values)):
            chosen.extend(values[rows][kept(rows)])
        return self.median_in_place(chosen)

    def median_in_place(self, values: GrowingArray) -> float:
        """Return the median of at least one value; their order is changed."""
        whole = values.rows()
        middle = sorted({(len(whole) - 1) // 2, len(whole) // 2})
        whole.partition(middle)
        found = float(whole[middle].mean())
        self.release_pages()
        return found

    def growing(self, dtype: npt.DTypeLike) -> GrowingArray:
        """Return an array without rows that grows at its end."""
        return GrowingArray(self, np.zeros((), dtype))


class GrowingArray:
    """Rows that are added one after the other; in memory are those of the last block.

    Parameters
    ----------
    disk : Disk
        Allocator of the final array.
    empty : ndarray
        Initial value of a new row, shape ().
    """

    def __init__(self, disk: Disk, empty: AnyArray) -> None:
        self._disk = disk
        self._empty = empty
        self._file: IO[bytes] | None = None
        self._stored: AnyArray | None = None
        self._newest = np.full(disk.block, empty)
        self._used = self._count = 0

    def __len__(self) -> int:
        return self._count + self._used

    def append(self) -> Any:  # noqa: ANN401  A row of a structured array has no type.
        """Add an empty row, and return it; it is to be filled before the next one is added."""
        if self._used == len(self._newest):
            self._store()
        self._used += 1
        return self._newest[self._used - 1]

    def extend(self, rows: AnyArray) -> None:
        """Add rows, not more than a block."""
        if self._used + len(rows) > len(self._newest):
            self._store()
        self._newest[self._used : self._used + len(rows)] = rows
        self._used += len(rows)

    def _store(self) -> None:
        try:
            if self._file is None:
                self._file = self._disk.file()
                finalize(self, self._file.close)
            self._file.seek(0, os.SEEK_END)
            self._file.write(self._newest[: self._used].tobytes())
            self._file.flush()
        except OSError as error:
            raise write_failure(self._disk.folder, error) from error
        self._count, self._used, self._stored = self._count + self._used, 0, None
        self._newest = np.full(self._disk.block, self._empty)

    def rows(self) -> AnyArray:
        """Return all rows, shape (N,), as a view that can be written."""
        if self._file is None:
            return self._newest[: self._used]
        if self._used:
            self._store()
        if self._stored is None:
            self._stored = self._disk.mapped(self._file, self._empty.dtype)
        return self._stored


def interpolated_locally(wanted: FloatArray, known: FloatArray, values: FloatArray) -> FloatArray:
    """Return values (N,) at ascending known x (N,), interpolated at wanted x (M,) in any order.

    As `numpy.interp`, reading no more than what lies around the wanted x.
    """
    around = surroundings(known, wanted)
    return np.asarray(np.interp(wanted, known[around], values[around]))


def surroundings(known: FloatArray | IndexArray, wanted: FloatArray | IndexArray) -> slice:
    """Return the slice of at least two ascending known x (N,) around all wanted ones (M,)."""
    if not len(wanted):
        return slice(0, 2)
    first = int(np.searchsorted(known, wanted.min())) - 1
    last = int(np.searchsorted(known, wanted.max(), "right")) + 1
    first = min(max(first, 0), len(known) - 2)
    return slice(max(first, 0), max(last, first + 2))


def running_sum(steps: FloatArray, before: float) -> FloatArray:
    """Return the sums of steps (N,) up to each, going on from the sum of those before."""
    return np.cumsum(np.concatenate(([before], steps)))[1:]


@dataclass(slots=True)
class Unwrapping:
    """Angles as `numpy.unwrap` gives them, block by block.

    Attributes
    ----------
    before : float or None
        The last angle as it came [rad].
    correction : float
        Multiple of 2 pi added to the last angle [rad].
    """

    before: float | None = None
    correction: float = 0.0

    def apply(self, angles: FloatArray) -> FloatArray:
        """Return the next angles (N,) without jumps [rad]."""
        if not len(angles):
            return angles
        steps = np.diff(angles, prepend=angles[0] if self.before is None else self.before)
        turned = np.mod(steps + math.pi, 2 * math.pi) - math.pi
        turned[(turned == -math.pi) & (steps > 0.0)] = math.pi
        changes = np.where(np.abs(steps) < math.pi, 0.0, turned - steps)
        corrections = running_sum(changes, self.correction)
        self.before, self.correction = float(angles[-1]), float(corrections[-1])
        return np.asarray(angles + corrections)
