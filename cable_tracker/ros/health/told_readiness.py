"""Whether a tracker is ready, and who listens to it, as its diagnostics tell."""

from __future__ import annotations

from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.tracking.status import WARMING_UP

READERS_OF = "subscribers of "
"""What stands before the full name of a topic; the value is how many subscribe to it."""


class ToldReadiness:
    """Readiness as the diagnostics of a tracker and of its watchers have reported it.

    Attributes
    ----------
    is_warm, is_warming : bool
        Whether the tracker is done with compiling, or has said that it is at it; at first neither.
    readers : dict of str to int
        Number of subscribers by the full name of a topic.
    """

    def __init__(self) -> None:
        self.is_warm = self.is_warming = False
        self.readers: dict[str, int] = {}

    def hear(self, status: Message) -> None:
        """Take one status of a DiagnosticArray into account."""
        self.is_warming = status.message == WARMING_UP
        self.is_warm = not self.is_warming
        for pair in status.values:
            if pair.key.startswith(READERS_OF):
                self.readers[pair.key.removeprefix(READERS_OF)] = int(pair.value)

    def has_readers(self, count: int, *topics: NodeTopic) -> bool:
        """Tell whether topics, by the last part of their names, have enough readers."""
        counts = {name.rpartition("/")[2]: readers for name, readers in self.readers.items()}
        return all(counts.get(topic.name.rpartition("/")[2], 0) >= count for topic in topics)


def is_guidance(status: Message) -> bool:
    """Tell whether a status of a DiagnosticArray is that of a controller or follower."""
    return str(status.name).endswith(": guidance")
