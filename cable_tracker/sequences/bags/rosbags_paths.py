"""Reader and writer of rosbags for bags at any path.

rosbags hands SQLite the path as a part of a URI, in which #, ? and % mean something else; it knows
suffixes in lower case alone; and it takes metadata, which are UTF-8, for text in the encoding of
the locale.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path, PosixPath
from typing import TYPE_CHECKING, Self
from urllib.parse import quote

from rosbags.rosbag2 import CompressionMode, Reader, StoragePlugin, Writer
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader, Sqlite3Writer

if TYPE_CHECKING:
    from rosbags.rosbag2.reader import ReaderProtocol
    from rosbags.rosbag2.writer import StorageWriter


def _quoted(path: Path) -> Path:
    """Return a path as it stands in a URI."""
    return Path(quote(os.fsencode(path)))


class _FolderPath(PosixPath):
    """Path of a bag's folder: texts in it are UTF-8, also the names that its metadata have."""

    def read_text(self, encoding: str | None = "utf-8", errors: str | None = None) -> str:
        """Read a text of UTF-8, as a recorder writes it in every locale."""
        return super().read_text(encoding, errors)

    def __truediv__(self, key: str | os.PathLike[str]) -> Self:
        """Return the path of the file whose name has the bytes of this text in UTF-8.

        Where there is none it is that with the letters of the text in the encoding of the locale.
        """
        name = os.fsdecode(os.fspath(key).encode("utf-8", "surrogateescape"))
        file = super().__truediv__(name)
        return file if file.exists() else super().__truediv__(key)


class _WrittenPath(PosixPath):
    """Path of a storage file, whose name goes into the metadata of its bag."""

    @property
    def name(self) -> str:
        """Text of the name's bytes in UTF-8, be the locale what it may; others are escaped."""
        return os.fsencode(super().name).decode("utf-8", "surrogateescape")


class _DatabaseReader(Sqlite3Reader):
    def open(self) -> None:
        path = Path(str(self.path))
        self.path = _quoted(path)
        try:
            super().open()
        finally:
            self.path = path


class _DatabaseWriter(Sqlite3Writer):
    def __init__(self, path: Path, compression: CompressionMode) -> None:
        super().__init__(_quoted(path), compression)
        self.path = path / f"{path.name}.db3"


class _FolderReader(DirectoryReader):
    def __init__(self, path: Path) -> None:
        super().__init__(_FolderPath(path))

    STORAGE_PLUGINS: Mapping[str, type[ReaderProtocol]] = {
        **DirectoryReader.STORAGE_PLUGINS,
        "sqlite3": _DatabaseReader,
    }


_READERS: Mapping[str, type[ReaderProtocol]] = {
    **Reader.STORAGE_PLUGINS,
    "dir": _FolderReader,
    ".db3": _DatabaseReader,
}


class BagReader(Reader):
    """Reader of a ROS 2 bag with suffixes in either case; see `rosbags.rosbag2.Reader`."""

    def __init__(self, path: Path) -> None:
        # The reader of a file is looked up by its suffix as it is written.
        readers = {
            name: _READERS[name.lower()]
            for name in ("dir", path.suffix)
            if name.lower() in _READERS
        }
        self.STORAGE_PLUGINS = readers
        super().__init__(path)


class BagFileWriter(Writer):
    """Writer of the files of a ROS 2 bag; see `rosbags.rosbag2.Writer`."""

    STORAGE_PLUGINS: Mapping[StoragePlugin, type[StorageWriter]] = {
        **Writer.STORAGE_PLUGINS,
        StoragePlugin.SQLITE3: _DatabaseWriter,
    }

    def close(self) -> None:
        """Write the index and the metadata; see `rosbags.rosbag2.Writer.close`."""
        if self.storage is not None:
            self.storage.path = _WrittenPath(self.storage.path)
        super().close()
