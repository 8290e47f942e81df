"""Messages out of a bag of any kind, through rosbags, and past rosbags where a bag is damaged.

rosbags reads nothing of a bag whose index is missing. To deliver the frames before the damage, such
a file is walked through from its beginning by the recovery readers of this folder.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock
from typing import Protocol
from weakref import WeakSet, finalize

import zstandard
from rosbags.rosbag1 import Reader as Reader1

from cable_tracker.errors import RecordingError, one_line
from cable_tracker.sequences.bags import mcap_recovery, ros1_recovery, sqlite_recovery
from cable_tracker.sequences.bags.bag_limits import (
    METADATA,
    PACKED_SUFFIX,
    ROS2_SUFFIXES,
    check_database,
    check_folder,
    check_overlap,
    limit_rosbags,
    room_to_unpack,
    unpacked_blocks,
)
from cable_tracker.sequences.bags.rosbags_paths import BagReader
from cable_tracker.sequences.bags.stored_message import StoredMessage
from cable_tracker.sequences.bags.topics import Topic
from cable_tracker.sequences.natural_order import naturally_sorted

_ROS1_SUFFIX = ".bag"
BAG_SUFFIXES = (*ROS2_SUFFIXES, _ROS1_SUFFIX)
_NO_END = "it has no end (a crashed recorder or a cut-off copy); read as far as it goes"

MORE_THAN_ROS2 = (
    "it is not of ROS 2 alone, or does not say that it is; what is of ROS 2 is read, without the"
    " index, which takes longer"
)


class BagStorage(Protocol):
    """Reader of a bag's serialised messages.

    Attributes
    ----------
    topics : dict of str to Topic
        Topics of the bag, by name.
    note : str
        Something the user should be told; empty if there is nothing.
    """

    topics: dict[str, Topic]
    note: str

    def messages(self, topics: Collection[str], start: int = 0) -> Generator[StoredMessage]:
        """Yield the messages of some topics in order of time; raise RecordingError at damage.

        Those that were written before `start` [ns] are left out.
        """
        ...

    def close(self) -> None:
        """End all readings, and close the files; another reading opens them again."""
        ...


_WALKERS: dict[str, Callable[[Path], Iterator[StoredMessage]]] = {
    ".mcap": mcap_recovery.read_messages,
    ".db3": sqlite_recovery.read_messages,
    ".bag": ros1_recovery.read_messages,
}


def is_ros1(path: Path) -> bool:
    """Tell whether a path names a ROS 1 bag; a folder may be called .bag and is none."""
    return path.suffix.lower() == _ROS1_SUFFIX and not path.is_dir()


def storage_files(path: Path) -> list[Path]:
    """Return the storage files of a bag folder in their natural order, or the file itself."""
    if not path.is_dir():
        return [path]
    return naturally_sorted(
        file for file in path.iterdir() if file.suffix.lower() in ROS2_SUFFIXES and file.is_file()
    )


def is_packed(path: Path) -> bool:
    """Tell whether a path names a storage file that a recorder compressed as a whole."""
    is_storage = Path(path.stem).suffix.lower() in ROS2_SUFFIXES
    return path.suffix.lower() == PACKED_SUFFIX and is_storage and path.is_file()


def packed_files(path: Path) -> list[Path]:
    """Return the compressed storage files of a folder, or the file itself if it is one.

    Beside the storage file that it is made of lies one that its recorder has not finished.
    """
    files = path.iterdir() if path.is_dir() else (path,)
    return [
        file
        for file in files
        if is_packed(file) and not (path.is_dir() and file.with_suffix("").exists())
    ]


def _walk(path: Path) -> Iterator[StoredMessage]:
    try:
        yield from _WALKERS[path.suffix.lower()](path)
    except OSError as error:
        raise RecordingError(one_line(error)) from error
    # The records of mcap are parsed by a library that does not say what it raises on damage.
    except Exception as error:
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(f"{type(error).__name__}: {one_line(error)}") from error


class RosbagsStorage:
    """A bag that rosbags can open.

    It is opened once for all that is read of it: at each opening rosbags parses the metadata, which
    takes a tenth of a second, and unpacks a bag that was compressed as a file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.note = ""
        self._check_limits()
        self._lock = Lock()
        self._readings: WeakSet[Generator[StoredMessage]] = WeakSet()
        self._shared: BagReader | None = None
        with self._opened() as reader:
            self._check_chunks(reader)
            self.topics = {
                name: Topic(
                    next(c.msgtype for c in reader.connections if c.topic == name), info.msgcount
                )
                for name, info in reader.topics.items()
            }
        if not all(isinstance(name, str) for name in self.topics):
            self.close()
            raise RecordingError(f"{METADATA} has a topic whose name is no text")

    @contextmanager
    def _opened(self) -> Iterator[Reader1 | BagReader]:
        """Give the reader to read with; of a ROS 1 bag one for each reading.

        It keeps the chunk that it has unpacked last, which two readings would take from each other.
        """
        limit_rosbags()
        if is_ros1(self._path):
            with Reader1(self._path) as reader:
                yield reader
            return
        if self._shared is None:
            shared = BagReader(self._path)
            shared.open()
            self._check_files(shared)
            self._check_unpacked(shared)
            self._leave_messages_packed(shared)
            self._shared, self._close_shared = shared, finalize(self, shared.close)
        yield self._shared

    def close(self) -> None:
        """End all readings, and close the files; another reading opens them again."""
        for reading in tuple(self._readings):
            reading.close()
        if self._shared is not None:
            self._shared = None
            self._close_shared()

    def _check_limits(self) -> None:
        if self._path.is_dir():
            check_folder(self._path)
        for file in storage_files(self._path):
            if file.suffix.lower() == ".db3":
                check_database(file)

    @staticmethod
    def _check_chunks(reader: Reader1 | BagReader) -> None:
        if isinstance(reader, Reader1):
            return
        for storage in getattr(reader.storage, "storages", [reader.storage]):
            check_overlap(getattr(storage, "chunks", ()))

    @staticmethod
    def _check_files(reader: BagReader) -> None:
        """Refuse metadata whose list of files is none: rosbags reads it, but cannot close it."""
        storage = reader.storage
        if not isinstance(getattr(storage, "files", []), list):
            vars(storage)["files"] = []
            reader.close()
            raise RecordingError(f"{METADATA} has files that are no list")

    @staticmethod
    def _check_unpacked(reader: BagReader) -> None:
        """Check databases that rosbags has unpacked as those that lie in the folder."""
        if reader.compression_mode != "file":
            return
        try:
            for storage in getattr(reader.storage, "storages", ()):
                if storage.path.suffix.lower() == ".db3":
                    check_database(storage.path)
        except BaseException:
            reader.close()
            raise

    @staticmethod
    def _leave_messages_packed(reader: BagReader) -> None:
        """Let a bag of compressed messages hand them out as they are; the reader unpacks them."""
        if reader.compression_mode == "message":
            storage = reader.storage
            storage.metadata = storage.metadata._replace(compression_mode=None)

    def _from_rosbags(self, topics: Collection[str], start: int) -> Generator[StoredMessage]:
        with self._opened() as reader:
            connections = [c for c in reader.connections if c.topic in topics]
            if not connections:
                return
            for connection, time, data in reader.messages(connections, start or None):
                yield StoredMessage(connection.topic, connection.msgtype, time, bytes(data))

    def messages(self, topics: Collection[str], start: int = 0) -> Generator[StoredMessage]:
        """Yield the messages of some topics in order of time, from a time [ns] on.

        Raises
        ------
        RecordingError
            At the damage, after all messages that could be read.
        """
        reading = self._read(topics, start)
        self._readings.add(reading)
        return reading

    def _read(self, topics: Collection[str], start: int) -> Generator[StoredMessage]:
        latest: int | None = None
        with closing(self._from_rosbags(topics, start)) as stored:
            while True:
                try:
                    with self._lock:  # Another thread may read at another place of the file.
                        message = next(stored, None)
                # rosbags raises what its parsers happen to raise, some twenty types by now.
                except Exception as error:  # noqa: BLE001
                    damage = RecordingError(one_line(error))
                    damage.__cause__ = error
                    break
                if message is None:
                    return
                latest = message.time
                yield message
        # rosbags gives up a whole chunk; a part of it may be intact.
        rest = SalvagedStorage(storage_files(self._path), damage, scan=False)
        for message in rest.messages(topics, start):
            if latest is None or message.time > latest:
                yield message


@dataclass(slots=True)
class _Scan:
    counts: dict[str, int] = field(default_factory=dict)
    types: dict[str, str] = field(default_factory=dict)

    def add(self, message: StoredMessage) -> None:
        self.counts[message.topic] = self.counts.get(message.topic, 0) + 1
        self.types[message.topic] = message.msgtype


class SalvagedStorage:
    """Files of a bag, each walked through as far as it goes.

    Parameters
    ----------
    files : list of Path
        The storage files in order.
    damage : RecordingError or None
        Why the bag had to be read this way, raised when the files are at their end; None if that
        is no damage, as after a crash of the recorder.
    scan : bool
        Whether to read everything once to find out what topics there are.
    """

    def __init__(
        self, files: list[Path], damage: RecordingError | None, *, scan: bool = True
    ) -> None:
        self._files = files
        self._damage = damage
        self.topics: dict[str, Topic] = {}
        self.note = ""
        if scan:
            self._scan()

    def _scan(self) -> None:
        scan = _Scan()
        try:
            for message in self._all():
                scan.add(message)
        except RecordingError as error:
            self._damage = self._damage or error
        self.topics = {name: Topic(scan.types[name], count) for name, count in scan.counts.items()}
        if not self.topics and self._damage:
            raise self._damage

    def _all(self) -> Iterator[StoredMessage]:
        for file in self._files:
            yield from _walk(file)

    def messages(self, topics: Collection[str], start: int = 0) -> Generator[StoredMessage]:
        """Yield the messages of some topics in the order they were written, from a time [ns] on.

        Raises
        ------
        RecordingError
            At the damage, after all messages that could be read.
        """
        try:
            for message in self._all():
                if message.topic in topics and message.time >= start:
                    yield message
        except RecordingError as error:
            raise (self._damage or error) from error
        if self._damage:
            raise self._damage

    def close(self) -> None:
        """Do nothing: a reading closes its files at its end."""


def _crashed_files(path: Path) -> list[Path]:
    """Return the mcap files of a bag that were never closed."""
    return [
        file
        for file in _mcap_files(path)
        if file.stat().st_size and not mcap_recovery.is_closed(file)
    ]


def _unmerged_log(path: Path) -> str:
    logs = [file.with_name(file.name + "-wal") for file in storage_files(path)]
    waiting = [log for log in logs if log.exists() and log.stat().st_size]
    if not waiting:
        return ""
    return (
        f"{waiting[0].name} holds messages of a recorder that did not end well; they are not read"
        " (merge them with: sqlite3 FILE.db3 'PRAGMA wal_checkpoint')"
    )


def _mcap_files(path: Path) -> list[Path]:
    return [file for file in storage_files(path) if _is_mcap(file)]


def _is_mcap(file: Path) -> bool:
    return file.suffix.lower() == ".mcap"


def _is_more_than_ros2(path: Path) -> bool:
    """Tell whether a bag is of mcap files that are not of ROS 2 alone, or do not say so."""
    files = _mcap_files(path)
    try:
        is_whole = all(map(mcap_recovery.is_closed, files))
        return is_whole and not all(map(mcap_recovery.is_ros2_alone, files))
    except Exception:  # noqa: BLE001  Damage, of which its reader tells.
        return False


def _open_without_metadata(path: Path) -> BagStorage:
    files = storage_files(path)
    if len(files) == 1:
        return open_storage(files[0])
    storage = SalvagedStorage(files, None)
    storage.note = _one_after_the_other(files)
    return storage


def _one_after_the_other(files: list[Path]) -> str:
    return f"{METADATA} is missing; {len(files)} files were read one after the other"


def _unpack(files: list[Path], folder: Path) -> tuple[list[Path], RecordingError | None]:
    """Unpack files into a folder, each as far as it goes; return the copies and the damage met."""
    copies: list[Path] = []
    damage: RecordingError | None = None
    room = room_to_unpack()
    for file in files:
        copies.append(folder / file.stem)
        with copies[-1].open("wb") as copy:
            try:
                copy.writelines(unpacked_blocks(file, room))
            except zstandard.ZstdError:
                damage = damage or RecordingError(f"{file.name} cannot be unpacked to its end")
            room -= copy.tell()
    return copies, damage


def _open_packed(path: Path) -> BagStorage:
    """Open compressed files without metadata, as a recorder that crashed leaves those it finished.

    They are read from copies, which go with the storage.
    """
    plain = storage_files(path) if path.is_dir() else []
    folder = TemporaryDirectory()
    try:
        copies, damage = _unpack(packed_files(path), Path(folder.name))
        files = naturally_sorted((*plain, *copies))
        storage = SalvagedStorage(files, damage)
    except BaseException:
        folder.cleanup()
        raise
    finalize(storage, folder.cleanup)
    if not all(mcap_recovery.is_closed(file) for file in files if _is_mcap(file)):
        storage.note = _NO_END
    elif len(files) > 1:
        storage.note = _one_after_the_other(files)
    return storage


def open_storage(path: Path) -> BagStorage:
    """Open a bag folder or a single .db3, .mcap or .bag file, and look what topics it holds.

    Raises
    ------
    RecordingError
        Not one message can be read. The message is the reason alone, without the path.
    """
    is_whole_bag = path.is_dir() and (path / METADATA).exists()
    if not is_whole_bag and packed_files(path):
        return _open_packed(path)
    if _crashed_files(path):
        storage: BagStorage = SalvagedStorage(storage_files(path), None)
        if not storage.topics:
            raise RecordingError("it breaks off before the first message")
        storage.note = _NO_END
        return storage
    if path.is_dir() and not (path / METADATA).exists():
        return _open_without_metadata(path)
    try:
        storage = RosbagsStorage(path)
    except Exception as error:
        damage = RecordingError(one_line(error))
        damage.__cause__ = error
        files = storage_files(path)
        if not files:
            raise damage from error
        if _is_more_than_ros2(path):
            # rosbags opens none of it, and nothing is damaged.
            storage = SalvagedStorage(files, None)
            storage.note = MORE_THAN_ROS2
            return storage
        return SalvagedStorage(files, damage)
    storage.note = _unmerged_log(path)
    return storage


def open_bag(path: Path) -> BagStorage:
    """Open a bag as `open_storage` does; an error names it, and says what to do.

    Raises
    ------
    RecordingError
        Not one message can be read.
    """
    try:
        is_ros1_mcap = any(mcap_recovery.profile_of(file) == "ros1" for file in _mcap_files(path))
        if not is_ros1_mcap:
            return open_storage(path)
    except (RecordingError, OSError) as error:
        raise RecordingError(
            f"{path}: not one message can be read ({one_line(error)}); check that the"
            " recording is a bag and was copied completely"
        ) from error
    raise RecordingError(
        f"{path}: holds ROS 1 messages, which are not read from mcap; give the .bag that it was"
        " made of, or convert it to a ROS 2 bag"
    )
