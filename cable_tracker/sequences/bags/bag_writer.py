"""Write ROS 2 bags."""

from __future__ import annotations

import re
import sqlite3
import struct
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from enum import Enum
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self

from rosbags.interfaces import Connection
from rosbags.rosbag2 import StoragePlugin, WriterError

from cable_tracker.atomic_output import PartialOutput
from cable_tracker.errors import OutputError, RecordingError, one_line, read_failure, write_failure
from cable_tracker.sequences.bags.rosbags_messages import typestore
from cable_tracker.sequences.bags.rosbags_paths import BagFileWriter
from cable_tracker.sequences.bags.storage_files import (
    METADATA,
    ROS2_SUFFIXES,
    TRUTH_FILE,
    VEHICLE_FILE,
)

_LATEST_STAMP = 2**63 - 1
_SIMULATED_VEHICLE = re.compile(
    rb"# What no topic of this bag says\.\ncable_height: \S+\naltitude_is_vertical: true\n"
)
"""What simulating writes into `vehicle.yaml`: it goes with its bag."""


class StorageFormat(str, Enum):
    """Format of a bag's storage file."""

    MCAP = "mcap"
    SQLITE3 = "sqlite3"


def _is_bag(path: Path) -> bool:
    return (path / METADATA).is_file()


def _is_of_bag(name: str) -> bool:
    """Tell whether a file is of those that converting and simulating write into a bag's folder."""
    return name in {METADATA, VEHICLE_FILE, TRUTH_FILE} or Path(name).suffix in ROS2_SUFFIXES


def kept_vehicle(path: Path) -> bytes | None:
    """Return the `vehicle.yaml` that the user has put into a bag which is to be replaced, if any.

    Raises
    ------
    RecordingError
        It cannot be read.
    """
    file = path / VEHICLE_FILE
    try:
        text = file.read_bytes() if _is_bag(path) and file.is_file() else b""
    except OSError as error:
        raise read_failure(file, error) from error
    return text if text and not _SIMULATED_VEHICLE.fullmatch(text) else None


def kept_notes(path: Path) -> list[str]:
    """Return a note if the `vehicle.yaml` of a bag that is replaced is kept; else none."""
    if kept_vehicle(path) is None:
        return []
    return [f"its {VEHICLE_FILE} was kept; remove it if the new bag is of another vehicle"]


class MessageSink(Protocol):
    """Interface for writing the messages of a frame; see `BagWriter`."""

    def write(self, topic: str, msgtype: str, message: object, stamp: int) -> None:
        """Write a message object."""
        ...

    def write_serialised(
        self, topic: str, msgtype: str, data: bytes | memoryview, stamp: int
    ) -> None:
        """Write a message that is serialised already."""
        ...


class NoMessages:
    """Takes messages where no bag is wanted, and forgets them."""

    def write(self, topic: str, msgtype: str, message: object, stamp: int) -> None:
        """Forget a message object."""

    def write_serialised(
        self, topic: str, msgtype: str, data: bytes | memoryview, stamp: int
    ) -> None:
        """Forget a serialised message."""


class BagWriter:
    """Writes a bag of ROS 2 Jazzy; to be used as a context manager.

    The bag appears at its path when the context ends without an exception. Until then it is written
    to a hidden folder beside it, which is removed if anything goes wrong.

    Parameters
    ----------
    overwrite : bool
        Replace a bag that lies at the path. Anything but a bag is never replaced, nor a bag beside
        which the user has put other files.
    vehicle : bytes or None
        What `vehicle.yaml` in its folder says. None: the user's in the bag that is replaced stays,
        if there is one; nor is that replaced by another.

    Raises
    ------
    OutputError
        From any method: the path is taken, or the disk does not let us write.
    """

    def __init__(
        self,
        path: Path,
        storage: StorageFormat = StorageFormat.MCAP,
        *,
        overwrite: bool = False,
        vehicle: bytes | None = None,
    ) -> None:
        self._path = path
        self._vehicle = vehicle
        self._storage = storage
        self._overwrite = overwrite
        self._connections: dict[tuple[str, str], Connection] = {}

    def __enter__(self) -> Self:
        self._folder = PartialOutput(
            self._path, overwrite=self._overwrite, is_ours=_is_bag, is_own_name=_is_of_bag
        )
        try:
            self._keep_vehicle()
            with self._translated_errors():
                self._writer = BagFileWriter(
                    self._folder.content,
                    version=BagFileWriter.VERSION_LATEST,
                    storage_plugin=StoragePlugin[self._storage.name],
                )
                self._writer.open()
        except (OutputError, RecordingError):
            self._folder.discard()
            raise
        return self

    def _keep_vehicle(self) -> None:
        """Take over what the user has written of the vehicle, or refuse to delete it."""
        kept = kept_vehicle(self._path)
        if kept is None:
            return
        if self._vehicle not in {None, kept}:
            raise OutputError(
                f"{self._path / VEHICLE_FILE}: says other things than that of the new bag and is"
                " not overwritten; move it elsewhere, or choose another name"
            )
        self._vehicle = kept

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if error is not None:
            self._abort()
            return
        try:
            with self._translated_errors():
                self._writer.close()
                if self._vehicle is not None:
                    (self._folder.content / VEHICLE_FILE).write_bytes(self._vehicle)
        except BaseException:
            self._abort()
            raise
        self._folder.commit()

    def write(self, topic: str, msgtype: str, message: object, stamp: int) -> None:
        """Write a message object of `typestore`.

        Parameters
        ----------
        msgtype : str
            Like ``sensor_msgs/msg/Image``.
        message : object
            An instance of ``typestore().types[msgtype]``.
        stamp : int
            Receive time [ns].
        """
        try:
            data = typestore().serialize_cdr(message, msgtype)
        except struct.error as error:
            raise OutputError(
                f"{self._path}: a message of {topic} has a number or a time that its type cannot"
                f" hold ({one_line(error)}); set the clock of the recording right"
            ) from error
        self.write_serialised(topic, msgtype, data, stamp)

    def write_serialised(
        self, topic: str, msgtype: str, data: bytes | memoryview, stamp: int
    ) -> None:
        """Write a message that is serialised already, in CDR; the rest as in `write`."""
        if not 0 <= stamp < _LATEST_STAMP:
            raise OutputError(
                f"{self._path}: {stamp} ns is no time that a bag can hold; set the clock of the"
                " recording right"
            )
        with self._translated_errors():
            self._writer.write(self._connection(topic, msgtype), stamp, data)

    def _connection(self, topic: str, msgtype: str) -> Connection:
        connection = self._connections.get((topic, msgtype))
        if connection is None:
            connection = self._writer.add_connection(topic, msgtype, typestore=typestore())
            self._connections[topic, msgtype] = connection
        return connection

    @contextmanager
    def _translated_errors(self) -> Iterator[None]:
        try:
            yield
        except (OSError, sqlite3.Error, WriterError) as error:
            raise write_failure(self._path, error) from error

    def _abort(self) -> None:
        # The storage may be the very thing that failed.
        with suppress(OSError, sqlite3.Error, WriterError):
            self._writer.abort()
        self._folder.discard()
