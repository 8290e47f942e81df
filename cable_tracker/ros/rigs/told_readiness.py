"""Whether a tracker is ready for a rig, as its diagnostics tell."""

from __future__ import annotations

from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.tracking.status_words import WARMING_UP


class ToldReadiness:
    """Readiness as the diagnostics of a tracker and of its watchers have reported it.

    Attributes
    ----------
    is_warm : bool
        Whether the tracker is done with compiling.
    """

    def __init__(self) -> None:
        self.is_warm = False
        self._readers: dict[str, int] = {}

    def hear(self, status: Message) -> None:
        """Take one status of a DiagnosticArray into account."""
        self.is_warm = status.message != WARMING_UP
        for pair in status.values:
            if pair.key.startswith("subscribers of "):
                self._readers[pair.key.rpartition("/")[2]] = int(pair.value)

    def has_readers(self, count: int, *topics: NodeTopic) -> bool:
        """Tell whether topics, by the last part of their names, have enough readers."""
        return all(self._readers.get(topic.name.rpartition("/")[2], 0) >= count for topic in topics)


def is_guidance(status: Message) -> bool:
    """Tell whether a status of a DiagnosticArray is that of a controller or follower."""
    return str(status.name).endswith(": guidance")
