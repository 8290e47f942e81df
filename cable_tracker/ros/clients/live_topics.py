"""Names of a tracker node's topics, found on the graph whatever they were remapped to."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass

from rclpy.node import Node
from sensor_msgs.msg import CompressedImage, Image

FRAME_REPORT = "frame_report"
"""Private topic that every tracker has from its start to its end."""

IMAGE_TYPES = {"sensor_msgs/msg/Image": Image, "sensor_msgs/msg/CompressedImage": CompressedImage}


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
    """Return the topics of a node by what it publishes and subscribes to; None if it has gone.

    Parameters
    ----------
    watcher : Node
        Looks at the graph.
    name : str
        Full name of the node.
    start_type : str
        Message type of the topic that takes a start.
    """
    namespace, _, node = name.rpartition("/")
    try:
        published = watcher.get_publisher_names_and_types_by_node(node, namespace or "/")
        read = watcher.get_subscriber_names_and_types_by_node(node, namespace or "/")
    except RuntimeError:
        return None  # It has gone since it was seen.
    image, image_type = _of_types(read, IMAGE_TYPES)
    # Ground truth is beside the image or the node, if it is published.
    beside = (f"{image.rpartition('/')[0]}/ground_truth", f"{namespace}/ground_truth")
    return LiveTopics(
        image=image,
        image_type=image_type,
        state=_of_types(published, ["sensor_msgs/msg/JointState"])[0],
        particles=_of_types(published, ["sensor_msgs/msg/PointCloud2"])[0],
        report=f"{name}/{FRAME_REPORT}",
        truth=next((topic for topic in beside if watcher.count_publishers(topic)), ""),
        start=_of_types(read, [start_type])[0],
        contour=_named(published, "geometry_msgs/msg/PolygonStamped", "contour"),
    )


def _of_types(topics: list[tuple[str, list[str]]], types: Container[str]) -> tuple[str, str]:
    """Return the first topic of one of some types, and its type."""
    for name, kinds in topics:
        for kind in kinds:
            if kind in types:
                return name, kind
    return "", ""


def _named(topics: list[tuple[str, list[str]]], kind: str, word: str) -> str:
    """Return the first topic of a type whose name ends with a word; empty if there is none."""
    return next((name for name, kinds in topics if kind in kinds and name.endswith(word)), "")
