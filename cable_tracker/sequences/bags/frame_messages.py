"""Messages of one frame, written into a bag."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.bags.bag_writer import MessageSink, NoMessages
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.frame import Frame, RawImage
from cable_tracker.sequences.messages.cable import make_state
from cable_tracker.sequences.messages.factory import Message, MessageMakers
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_compressed_image, make_image
from cable_tracker.sequences.messages.target import make_polygon
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg
from cable_tracker.target.model.estimate import Box, box_corners


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


def write_truth(bag: MessageSink, frame: Frame) -> None:
    """Write a frame's ground truth if it has some."""
    if frame.truth is not None:
        output = FrameMessages(bag, frame)
        truth = make_state(output.factory, output.header, frame.truth)
        output.write(node_topics.GROUND_TRUTH, truth)


def write_box(bag: MessageSink, frame: Frame, box: Box | None) -> None:
    """Write the true box of a frame: four corners, or none where the target is out of view."""
    output = FrameMessages(bag, frame)
    corners = np.empty((0, 2)) if box is None else box_corners(box)
    output.write(node_topics.TRUE_BOX, make_polygon(output.factory, output.header, corners))


def write_frame(bag: MessageSink, frame: Frame) -> None:
    """Write a frame's image, and its ground truth if it has some."""
    write_truth(bag, frame)
    output = FrameMessages(bag, frame)
    factory, header, image = output.factory, output.header, frame.image
    if isinstance(image, RawImage):
        output.write(node_topics.IMAGE, make_image(factory, image, header))
    else:
        output.write(node_topics.COMPRESSED_IMAGE, make_compressed_image(factory, image, header))
