"""Topics of a tracker node, found on the graph whatever they were remapped to, and listened to."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

from cable_tracker.ros import qos
from cable_tracker.ros.clients.live_frames import LiveFrames
from cable_tracker.ros.endpoints import publisher, subscription
from cable_tracker.ros.qos import endpoint_name
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.frame import CompressedImage, RawImage
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.images import read_compressed_image, read_image
from cable_tracker.sequences.node_topics import NodeTopic, TrackerTopics

WATCHED = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Pictures for people: losing one is no harm, and a slow viewer must not slow the camera."""

IMAGE_READERS: dict[NodeTopic, Callable[[Message], RawImage | CompressedImage]] = {
    node_topics.IMAGE: read_image,
    node_topics.COMPRESSED_IMAGE: read_compressed_image,
}

LiveTopics = dict[NodeTopic, str]
"""What the topics of a node are called on the graph, those alone that are there, in the order in
which they are listened to."""


def find_topics(watcher: Node, name: str, topics: TrackerTopics) -> LiveTopics:
    """Return the topics of a node by what it publishes and subscribes to; none if it is not there.

    A node is there while its reports have a publisher. Its endpoints are asked for by topic: the
    graph may keep the name of a process that is gone, and answers a question by that name with the
    topics of either, also when a new process bears it.

    Parameters
    ----------
    watcher : Node
        Looks at the graph.
    name : str
        Full name of the node.
    topics : TrackerTopics
        Its topics as they are called without remappings.
    """
    report = topics.report.of_node(name)
    if not _is_among(name, watcher.get_publishers_info_by_topic(report)):
        return {}
    listed = watcher.get_topic_names_and_types()

    def names(topic: NodeTopic, of: Callable[[str], list[TopicEndpointInfo]]) -> list[str]:
        """Return the names of what has the type of a topic and an endpoint of the node."""
        alike = (each for each, types in listed if topic.type_name in types)
        return [each for each in alike if _is_among(name, of(each))]

    read = {
        topic: names(topic, watcher.get_subscriptions_info_by_topic)
        for topic in (*IMAGE_READERS, topics.start)
    }
    published = {
        topic: names(topic, watcher.get_publishers_info_by_topic)
        for topic in (node_topics.CONTOUR, node_topics.PARTICLES, node_topics.STATE)
    }
    published[node_topics.CONTOUR].sort(key=_unlikeness_to_contour)
    # Ground truth is beside the image or the node, if it is published.
    beside = [
        f"{each.rpartition('/')[0]}{node_topics.GROUND_TRUTH.global_name}"
        for each in (*(image for topic in IMAGE_READERS for image in read[topic]), name)
    ]
    truth = [each for each in beside if watcher.count_publishers(each)]
    # Messages that have come together are taken in the order of these: a frame is shown as soon as
    # all is there that the node says of it, and must not leave its truth behind.
    found = {
        node_topics.GROUND_TRUTH: truth,
        **read,
        **published,
        topics.report: [report],
    }
    return {topic: those[0] for topic, those in found.items() if those}


def _is_among(name: str, endpoints: list[TopicEndpointInfo]) -> bool:
    """Tell whether one of some endpoints is a node's."""
    return any(endpoint_name(endpoint) == name for endpoint in endpoints)


def _unlikeness_to_contour(name: str) -> tuple[bool, bool]:
    """Return the sort key of a polygon topic: the contour comes first.

    The box is another one. Either may be remapped, so that the name of the other tells it.
    """
    return not name.endswith(node_topics.CONTOUR.name), name.endswith(node_topics.BOX.name)


class LiveConnection:
    """Hands what a node's topics say on, and publishes where it takes a start.

    Parameters
    ----------
    node : Node
        Listens.
    frames : LiveFrames
        Takes the messages.

    Attributes
    ----------
    topics : LiveTopics
        Names of what is listened to; empty while no node is there.
    start : Publisher or None
        None while the node takes no start.
    """

    def __init__(self, node: Node, frames: LiveFrames) -> None:
        self._node = node
        self._frames = frames
        self._subscriptions: list[Subscription] = []
        self.topics: LiveTopics = {}
        self.start: Publisher | None = None

    def change(self, topics: LiveTopics) -> None:
        """Listen to these topics from now on."""
        if topics == self.topics:
            return
        for each in self._subscriptions:
            self._node.destroy_subscription(each)
        if self.start is not None:
            self._node.destroy_publisher(self.start)
        self._subscriptions, self.start, self.topics = [], None, topics
        for topic, name in topics.items():
            if topic is self._frames.TOPICS.start:
                self.start = publisher(self._node, topic, qos.RESULTS, name=name)
            else:
                take = partial(self._take, topic)
                listening = subscription(self._node, topic, take, WATCHED, name=name)
                self._subscriptions.append(listening)

    def _take(self, topic: NodeTopic, message: Message) -> None:
        if topic in IMAGE_READERS:
            self._frames.take_image(message.header, IMAGE_READERS[topic](message))
        else:
            self._frames.take(topic, message)
