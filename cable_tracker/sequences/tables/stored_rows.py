"""Rows of a table that are added while a recording is read, on disk but for the newest."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import IO, Generic, TypeVar, overload
from weakref import finalize

from cable_tracker.errors import write_failure

Row = TypeVar("Row")

BLOCK = 1024
"""Rows that are kept in memory until they are written together."""


class StoredRows(Sequence[Row], Generic[Row]):
    """Rows in the order in which they were added.

    The file has no name, so that it takes no room after a process that was killed, and holds what
    this process has written.

    Parameters
    ----------
    block : int
        Rows that are kept in memory.
    """

    def __init__(self, folder: Path, block: int = BLOCK) -> None:
        self._folder = folder
        self._block = block
        self._file: IO[bytes] | None = None
        self._places: list[int] = []
        self._newest: list[Row] = []

    def __len__(self) -> int:
        return len(self._places) * self._block + len(self._newest)

    def append(self, row: Row) -> None:
        """Add a row.

        Raises
        ------
        OutputError
            The disk does not let us write.
        """
        self._newest.append(row)
        if len(self._newest) == self._block:
            try:
                self._store()
            except OSError as error:
                raise write_failure(self._folder, error) from error

    def _store(self) -> None:
        if self._file is None:
            self._file = tempfile.TemporaryFile(dir=self._folder)  # noqa: SIM115  Closed below.
            finalize(self, self._file.close)
        place = self._file.seek(0, 2)
        pickle.dump(self._newest, self._file)
        self._file.flush()
        self._places.append(place)
        self._newest = []

    def _stored(self, number: int) -> list[Row]:
        if self._file is None or number == len(self._places):
            return self._newest
        self._file.seek(self._places[number])
        rows: list[Row] = pickle.load(self._file)
        return rows

    def __iter__(self) -> Iterator[Row]:
        for number in range(len(self._places) + 1):
            yield from self._stored(number)

    @overload
    def __getitem__(self, index: int) -> Row: ...

    @overload
    def __getitem__(self, index: slice) -> list[Row]: ...

    def __getitem__(self, index: int | slice) -> Row | list[Row]:
        if isinstance(index, slice):
            start, stop, step = index.indices(len(self))
            if step < 0:
                return list(self)[index]
            return list(islice(self, start, stop, step))
        number = range(len(self))[index]
        return self._stored(number // self._block)[number % self._block]
