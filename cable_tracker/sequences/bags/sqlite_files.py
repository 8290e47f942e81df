"""Databases of sqlite3 bags: checked, and read without their indices where they are damaged.

SQLite runs queries that a database holds, and they need not end. One that holds any is refused
before it takes time or memory.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from cable_tracker.errors import RecordingError
from cable_tracker.sequences.bags.bag_limits import BLOCK, LARGEST_UNPACKED
from cable_tracker.sequences.bags.bag_storage import StoredMessage

SMALLEST_ROW = 8
"""Smallest size of a row of a database in its file [bytes]."""

STEPS_PER_ROW = 40
SPARE_STEPS = 200_000
"""Number of steps that SQLite may take to count the rows of a file, besides those for each row."""

CHECK_EVERY = 10_000

_GENERATED = (2, 3)


def _opened_database(path: Path) -> sqlite3.Connection:
    """Open a database to be read as it lies there, without its log, in values of limited size."""
    database = sqlite3.connect(path.resolve().as_uri() + "?mode=ro&immutable=1", uri=True)
    database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST_UNPACKED)
    return database


def check_database(path: Path) -> None:
    """Check that a database is plain tables, as a recorder writes them, and as large as its file.

    What is damaged but finite passes; its reader will meet the damage.

    Raises
    ------
    RecordingError
        It holds code (views, triggers, virtual tables, computed columns), or rows without end.
    """
    size = path.stat().st_size
    steps = SPARE_STEPS + STEPS_PER_ROW * size // SMALLEST_ROW
    left = [steps // CHECK_EVERY]

    def out_of_steps() -> bool:
        left[0] -= 1
        return left[0] < 0

    with closing(_opened_database(path)) as database:
        database.set_progress_handler(out_of_steps, CHECK_EVERY)
        database.text_factory = bytes
        try:
            for table in _plain_tables(database):
                _check_table(database, table, size)
        except (sqlite3.Error, MemoryError, OverflowError) as error:
            if left[0] < 0:
                raise RecordingError("it claims more rows than its file can hold") from error


def _plain_tables(database: sqlite3.Connection) -> list[bytes]:
    objects = database.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
    for kind, _, sql in objects:
        if kind in (b"view", b"trigger") or b"VIRTUAL" in bytes(sql or b"").upper()[:20]:
            raise RecordingError(
                "its database holds views, triggers or virtual tables, which no recorder writes"
            )
    return [bytes(name) for kind, name, _ in objects if kind == b"table"]


def _check_table(database: sqlite3.Connection, table: bytes, size: int) -> None:
    name = _quoted(table)
    columns = database.execute(f"PRAGMA table_xinfo({name})").fetchall()
    if any(column[6] in _GENERATED for column in columns):
        raise RecordingError("its database computes columns, which no recorder does")
    sums = "+".join(f"total(length({_quoted(column[1])}))" for column in columns)
    (total,) = database.execute(f"SELECT {sums} FROM {name}").fetchone()
    # Numbers count by their digits, of which a byte holds less than three, and a key has no bytes.
    if table == b"messages" and total > 4 * size + BLOCK:
        raise RecordingError("it claims more data than its file can hold")
    if table == b"topics":
        query = f"SELECT count(*) - count(DISTINCT id) FROM {name}"
        if database.execute(query).fetchone()[0]:
            raise RecordingError("several of its topics have the same number")


def _quoted(name: bytes) -> str:
    return '"' + name.decode(errors="replace").replace('"', '""') + '"'


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
        with closing(_opened_database(path)) as database:
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
