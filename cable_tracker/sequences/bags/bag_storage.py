"""Interface of the readers of bags, intact or damaged: topics, and serialised messages.

Nodes know it too, which read no bags: what unpacks bags and videos takes long to import.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"
FOXGLOVE = "foxglove_msgs/msg/CompressedVideo"
FFMPEG = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket"
VIDEO_TYPES = (FOXGLOVE, FFMPEG)
IMAGE_TYPES = (IMAGE, COMPRESSED_IMAGE, *VIDEO_TYPES)


@dataclass(frozen=True, slots=True, eq=False)
class StoredMessage:
    """A serialised message.

    Attributes
    ----------
    topic : str
        Name of the topic.
    msgtype : str
        Name of the type, like ``sensor_msgs/msg/Image``.
    time : int
        Time of reception by the recorder [ns].
    data : bytes
        CDR (ROS 2) or ROS 1 serialisation.
    """

    topic: str
    msgtype: str
    time: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Topic:
    """One topic of a bag.

    Attributes
    ----------
    msgtype : str
        Name of the message type.
    count : int
        Number of messages.
    """

    msgtype: str
    count: int


def unreadable_note(topic: str, count: int, reason: str) -> str:
    """Return a sentence about messages of a topic that cannot be read; `reason`: of the first."""
    return (
        f"{topic}: {count} of its messages cannot be read and are left out (the first: {reason});"
        " check how the bag was recorded"
    )


def named_topics(topics: Iterable[str], wanted: str) -> list[str]:
    """Return the topics of a name that a user gives, with a slash at the beginning or without."""
    return [name for name in topics if name.strip("/") == wanted.strip("/")]


def image_topics(topics: Mapping[str, Topic]) -> dict[str, Topic]:
    """Return the topics that hold images or a stream of video."""
    return {name: t for name, t in topics.items() if t.msgtype in IMAGE_TYPES}


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
