"""Messages out of a bag through rosbags, and past it from the place where one is damaged."""

from __future__ import annotations

from collections.abc import Collection, Generator, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from threading import Lock
from weakref import WeakSet, finalize

from rosbags.rosbag1 import Reader as Reader1

from cable_tracker.errors import RecordingError, one_line
from cable_tracker.sequences.bags.bag_limits import check_folder, check_overlap, limit_rosbags
from cable_tracker.sequences.bags.bag_storage import StoredMessage, Topic
from cable_tracker.sequences.bags.rosbags_paths import BagReader
from cable_tracker.sequences.bags.salvaged_storage import SalvagedStorage
from cable_tracker.sequences.bags.sqlite_files import check_database
from cable_tracker.sequences.bags.storage_files import METADATA, is_ros1, storage_files


def _opened_bag(path: Path) -> BagReader:
    """Return the open reader of a ROS 2 bag, once what rosbags trusts has been checked.

    Raises
    ------
    RecordingError
        The bag is refused.
    Exception
        rosbags cannot open it; it raises what its parsers happen to raise.
    """
    reader = BagReader(path)
    reader.open()
    storage = reader.storage
    try:
        if not isinstance(getattr(storage, "files", []), list):
            # rosbags reads such metadata, but cannot close its files.
            vars(storage)["files"] = []
            raise RecordingError(f"{METADATA} has files that are no list")
        if not all(isinstance(name, str) for name in reader.topics):
            raise RecordingError(f"{METADATA} has a topic whose name is no text")
        for part in getattr(storage, "storages", [storage]):
            check_overlap(getattr(part, "chunks", ()))
            if reader.compression_mode == "file" and part.path.suffix.lower() == ".db3":
                # rosbags has unpacked it; those that lie in the folder were checked before.
                check_database(part.path)
    except BaseException:
        reader.close()
        raise
    if reader.compression_mode == "message":
        # Messages are handed out as they are, and unpacked where they are deserialised.
        storage.metadata = storage.metadata._replace(compression_mode=None)
    return reader


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
            self.topics = {
                name: Topic(
                    next(c.msgtype for c in reader.connections if c.topic == name), info.msgcount
                )
                for name, info in reader.topics.items()
            }

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
            self._shared = _opened_bag(self._path)
            self._close_shared = finalize(self, self._shared.close)
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
