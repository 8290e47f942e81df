"""What every reader of a bag's serialised messages offers, intact or damaged."""

from __future__ import annotations

from collections.abc import Collection, Generator
from typing import Protocol

from cable_tracker.sequences.bags.stored_message import StoredMessage
from cable_tracker.sequences.bags.topics import Topic


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
