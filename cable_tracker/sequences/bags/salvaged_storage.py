"""Messages out of a bag past rosbags, which reads nothing of one whose index is missing.

To deliver the frames before the damage, each file is walked through from its beginning by the
recovery readers of this folder.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Generator, Iterator
from pathlib import Path

from cable_tracker.errors import RecordingError, one_line
from cable_tracker.sequences.bags import mcap_recovery, ros1_recovery, sqlite_files
from cable_tracker.sequences.bags.bag_storage import StoredMessage, Topic

_WALKERS: dict[str, Callable[[Path], Iterator[StoredMessage]]] = {
    ".mcap": mcap_recovery.read_messages,
    ".db3": sqlite_files.read_messages,
    ".bag": ros1_recovery.read_messages,
}


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
        counts: Counter[str] = Counter()
        types: dict[str, str] = {}
        try:
            for message in self._all():
                counts[message.topic] += 1
                types[message.topic] = message.msgtype
        except RecordingError as error:
            self._damage = self._damage or error
        self.topics = {name: Topic(types[name], count) for name, count in counts.items()}
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
