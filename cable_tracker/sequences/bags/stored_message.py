"""One message as it lies in a bag, whatever the kind of bag."""

from __future__ import annotations

from dataclasses import dataclass


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
