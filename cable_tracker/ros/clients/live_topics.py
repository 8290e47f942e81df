"""Topics of a tracker node, found on the graph whatever they were remapped to, and listened to."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass
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
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.images import read_compressed_image, read_image
from cable_tracker.sequences.node_topics import NodeTopic

WATCHED = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Pictures for people: losing one is no harm, and a slow viewer must not slow the camera."""

PUBLISHED_TYPES = {
    topic.type_name
    for topic in (node_topics.STATE, node_topics.PARTICLES, node_topics.CONTOUR, node_topics.BOX)
}

IMAGE_TOPICS = {
    topic.type_name: topic for topic in (node_topics.IMAGE, node_topics.COMPRESSED_IMAGE)
}


@dataclass(frozen=True, slots=True)
class LiveTopics:
    """Names on the graph, whatever they were remapped to; empty where there is none."""

    image: str
    image_type: str
    state: str
    particles: str
    report: str
    truth: str
    start: str
    contour: str = ""


def find_topics(watcher: Node, name: str, start_type: str) -> LiveTopics | None:
    """Return the topics of a node by what it publishes and subscribes to; None if it is not there.

    A node is there while its reports have a publisher. Its endpoints are asked for by topic: the
    graph may keep the name of a process that is gone, and answers a question by that name with the
    topics of either, also when a new process bears it.

    Parameters
    ----------
    watcher : Node
        Looks at the graph.
    name : str
        Full name of the node.
    start_type : str
        Message type of the topic that takes a start.
    """
    report = node_topics.FRAME_REPORT.of_node(name)
    if not _is_among(name, watcher.get_publishers_info_by_topic(report)):
        return None
    topics = watcher.get_topic_names_and_types()
    published = _of_node(name, topics, PUBLISHED_TYPES, watcher.get_publishers_info_by_topic)
    read_types = {*IMAGE_TOPICS, start_type}
    read = _of_node(name, topics, read_types, watcher.get_subscriptions_info_by_topic)
    image, image_type = _of_types(read, IMAGE_TOPICS)
    # Ground truth is beside the image or the node, if it is published.
    beside = [
        f"{place}{node_topics.GROUND_TRUTH.global_name}"
        for place in (image.rpartition("/")[0], name.rpartition("/")[0])
    ]
    return LiveTopics(
        image=image,
        image_type=image_type,
        state=_of_types(published, [node_topics.STATE.type_name])[0],
        particles=_of_types(published, [node_topics.PARTICLES.type_name])[0],
        report=report,
        truth=next((topic for topic in beside if watcher.count_publishers(topic)), ""),
        start=_of_types(read, [start_type])[0],
        contour=_contour_of(published),
    )


def _of_node(
    name: str,
    topics: list[tuple[str, list[str]]],
    types: Container[str],
    endpoints: Callable[[str], list[TopicEndpointInfo]],
) -> list[tuple[str, list[str]]]:
    """Return those topics of some types that a node has an endpoint on."""
    return [
        (topic, kinds)
        for topic, kinds in topics
        if any(kind in types for kind in kinds) and _is_among(name, endpoints(topic))
    ]


def _is_among(name: str, endpoints: list[TopicEndpointInfo]) -> bool:
    """Tell whether one of some endpoints is a node's."""
    return any(endpoint_name(endpoint) == name for endpoint in endpoints)


def _of_types(topics: list[tuple[str, list[str]]], types: Container[str]) -> tuple[str, str]:
    """Return the first topic of one of some types, and its type."""
    for name, kinds in topics:
        for kind in kinds:
            if kind in types:
                return name, kind
    return "", ""


def _contour_of(topics: list[tuple[str, list[str]]]) -> str:
    """Return the polygon that is the contour; empty if there is none.

    The box is another one. Either may be remapped, so that the name of the other tells it.
    """
    polygons = [name for name, kinds in topics if node_topics.CONTOUR.type_name in kinds]
    return min(
        polygons,
        key=lambda name: (
            not name.endswith(node_topics.CONTOUR.name),
            name.endswith(node_topics.BOX.name),
        ),
        default="",
    )


class LiveConnection:
    """Hands what a node's topics say on, and publishes where it takes a start.

    Parameters
    ----------
    node : Node
        Listens.
    frames : LiveFrames
        Takes the messages.
    start_topic : NodeTopic
        Takes a start.

    Attributes
    ----------
    topics : LiveTopics or None
        Names of what is listened to; None before a node was found.
    start : Publisher or None
        None while the node takes no start.
    """

    def __init__(self, node: Node, frames: LiveFrames, start_topic: NodeTopic) -> None:
        self._node = node
        self._frames = frames
        self._start_topic = start_topic
        self._subscriptions: list[Subscription] = []
        self.topics: LiveTopics | None = None
        self.start: Publisher | None = None

    def change(self, topics: LiveTopics | None) -> None:
        """Listen to these topics from now on; None: to none."""
        if topics == self.topics:
            return
        for each in self._subscriptions:
            self._node.destroy_subscription(each)
        if self.start is not None:
            self._node.destroy_publisher(self.start)
        self._subscriptions, self.start, self.topics = [], None, topics
        if topics is None:
            return
        image = IMAGE_TOPICS.get(topics.image_type, node_topics.IMAGE)
        on_image = self._on_image if image is node_topics.IMAGE else self._on_compressed_image
        self._listen(image, topics.image, on_image)
        for topic, name in (
            (node_topics.GROUND_TRUTH, topics.truth),
            (node_topics.CONTOUR, topics.contour),
            (node_topics.PARTICLES, topics.particles),
            (node_topics.FRAME_REPORT, topics.report),
            (node_topics.STATE, topics.state),
        ):
            self._listen(topic, name, partial(self._frames.take, topic))
        if topics.start:
            self.start = publisher(self._node, self._start_topic, qos.RESULTS, name=topics.start)

    def _listen(self, topic: NodeTopic, name: str, callback: Callable[[Message], None]) -> None:
        """Subscribe to a topic that the graph calls by a name, if it has one."""
        if name:
            listening = subscription(self._node, topic, callback, WATCHED, name=name)
            self._subscriptions.append(listening)

    def _on_image(self, message: Message) -> None:
        self._frames.take_image(message.header, read_image(message))

    def _on_compressed_image(self, message: Message) -> None:
        self._frames.take_image(message.header, read_compressed_image(message))
