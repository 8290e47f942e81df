"""Read what is left of a damaged sqlite3 bag, message by message, without its indices."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.bag_storage import StoredMessage
from cable_tracker.sequences.bags.database_limits import check_database, opened_database


def _decoded(data: bytes) -> str:
    return data.decode(errors="replace")


def read_messages(path: Path) -> Iterator[StoredMessage]:
    """Yield the messages of a db3 file in the order they were written, up to the damage.

    Raises
    ------
    RecordingError
        Where the damage is. The message is the reason alone, without the path.
    """
    check_database(path)
    try:
        with closing(opened_database(path)) as database:
            database.text_factory = _decoded
            # Without this SQLite refuses a file that is shorter than its header says.
            database.execute("PRAGMA writable_schema=ON")
            topics = {
                key: (str(name), str(msgtype))
                for key, name, msgtype in database.execute("SELECT id, name, type FROM topics")
            }
            # In the order of the table: sorting by time would need the index on it.
            rows = database.execute("SELECT topic_id, timestamp, data FROM messages")
            for topic_id, time, data in rows:
                if topic_id in topics and isinstance(time, int) and isinstance(data, bytes):
                    yield StoredMessage(*topics[topic_id], time, data)
    except (sqlite3.Error, OverflowError, MemoryError) as error:
        raise RecordingError(f"the database is damaged: {error}") from error
