"""Topics of a bag, and which of them hold pictures.

Nodes know them too, which read no bags: what unpacks bags and videos takes long to import.
"""

from __future__ import annotations

from dataclasses import dataclass

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"
FOXGLOVE = "foxglove_msgs/msg/CompressedVideo"
FFMPEG = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket"
VIDEO_TYPES = (FOXGLOVE, FFMPEG)
IMAGE_TYPES = (IMAGE, COMPRESSED_IMAGE, *VIDEO_TYPES)


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


def image_topics(topics: dict[str, Topic]) -> dict[str, Topic]:
    """Return the topics that hold images or a stream of video."""
    return {name: t for name, t in topics.items() if t.msgtype in IMAGE_TYPES}
