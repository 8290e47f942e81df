"""Messages of one frame, written into a bag."""

from __future__ import annotations

from collections.abc import Callable

from cable_tracker.arrays import Image
from cable_tracker.sequences.bags.bag_writer import MessageSink, NoMessages
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.factory import Message, MessageMakers
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_compressed_image
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg


class FrameMessages:
    """Writes messages about one frame; those that would be forgotten are not made.

    Attributes
    ----------
    factory : RosbagsMessages
        Makes the messages.
    header : Message
        Stamp and frame of the image.
    """

    def __init__(self, bag: MessageSink, frame: Frame) -> None:
        self._bag, self._bag_time = bag, frame.bag_time
        self.factory = RosbagsMessages()
        self.header = make_header(self.factory, frame.stamp, frame.frame_id)

    def write(self, topic: NodeTopic, message: Message) -> None:
        """Write one message."""
        self._bag.write(topic.global_name, topic.type_name, message, self._bag_time)

    def write_all(self, makers: MessageMakers) -> None:
        """Write all messages that the node would publish, in their order."""
        if isinstance(self._bag, NoMessages):
            return
        for topic, make in makers.items():
            self.write(topic, make())

    def write_overlay(self, topic: NodeTopic, draw: Callable[[], Image]) -> None:
        """Write a picture, blue-green-red, shape (H, W, 3), uint8, as JPEG."""
        self.write_all(
            {topic: lambda: make_compressed_image(self.factory, encode_jpeg(draw()), self.header)}
        )
