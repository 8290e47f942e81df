"""Reader and writer of rosbags for bags at any path.

rosbags hands SQLite the path as a part of a URI, in which #, ? and % mean something else; and it
knows suffixes in lower case alone.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING
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
