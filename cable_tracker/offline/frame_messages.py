"""Messages of one frame, written into the bag of results."""

from __future__ import annotations

from cable_tracker.sequences.bags.bag_writer import MessageSink
from cable_tracker.sequences.bags.rosbags_messages import RosbagsMessages
from cable_tracker.sequences.frame import Frame
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.node_topics import NodeTopic


class FrameMessages:
    """Writes messages with the header of one frame."""

    def __init__(self, bag: MessageSink, frame: Frame) -> None:
        self._bag = bag
        self._stamp, self._bag_time = frame.stamp, frame.bag_time
        self._factory = RosbagsMessages()
        self._header = make_header(self._factory, frame.stamp, frame.frame_id)

    def _write(self, topic: NodeTopic, message: Message) -> None:
        self._bag.write(topic.global_name, topic.type_name, message, self._bag_time)
