"""State of trackers by their diagnostics: status, warm-up, and number of subscribers."""

from __future__ import annotations

import math
import time

from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.tracking.status import WARMING_UP

READERS_OF = "subscribers of "
"""What stands before the full name of a topic; the value is how many subscribe to it."""

HOLDS = 60.0
"""Time without another message for which a tracker still counts as warming up [s].

The compiler keeps the interpreter to itself at times, and the diagnostics with it.
"""


class TrackerHealth:
    """Statuses of trackers, and the subscribers of their topics, by the latest diagnostics.

    Attributes
    ----------
    readers : dict of str to int
        Number of subscribers by the full name of a topic.
    """

    def __init__(self) -> None:
        self._statuses: dict[str, tuple[str, float]] = {}
        self.readers: dict[str, int] = {}

    def take(self, message: Message) -> None:
        """Take a DiagnosticArray, but not what it says of controllers and followers."""
        for status in message.status:
            if is_guidance(status):
                continue
            self._statuses[str(status.hardware_id)] = str(status.message), time.monotonic()
            for pair in status.values:
                # Any node of a robot may say anything.
                if pair.key.startswith(READERS_OF) and pair.value.isdecimal():
                    self.readers[pair.key.removeprefix(READERS_OF)] = int(pair.value)

    def status(self, name: str) -> str:
        """Return the status of a node by its full name; empty before the first."""
        return self._statuses.get(name, ("", 0.0))[0]

    def age(self, name: str) -> float:
        """Return the time since the last status of a node by its full name [s]."""
        return time.monotonic() - self._statuses.get(name, ("", -math.inf))[1]

    def warming(self) -> list[str]:
        """Return the full names of the nodes that are warming up."""
        return sorted(
            name
            for name, (status, _) in self._statuses.items()
            if status == WARMING_UP and self.age(name) <= HOLDS
        )

    def is_warm(self) -> bool:
        """Tell whether trackers have told of themselves, and all are done with compiling."""
        statuses = [status for status, _ in self._statuses.values()]
        return bool(statuses) and WARMING_UP not in statuses

    def has_readers(self, count: int, *topics: NodeTopic) -> bool:
        """Tell whether topics, by the last part of their names, have enough readers."""
        counts = {name.rpartition("/")[2]: readers for name, readers in self.readers.items()}
        return all(counts.get(topic.name.rpartition("/")[2], 0) >= count for topic in topics)


def is_guidance(status: Message) -> bool:
    """Tell whether a status of a DiagnosticArray is that of a controller or follower."""
    return str(status.name).endswith(": guidance")
