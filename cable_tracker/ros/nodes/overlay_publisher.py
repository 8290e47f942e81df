"""The picture that people look at, raw and as JPEG, for those who subscribe."""

from __future__ import annotations

from cable_tracker.arrays import Image as Picture
from cable_tracker.ros import qos
from cable_tracker.ros.health.watched_endpoints import WatchedEndpoints
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.images import make_compressed_image, make_image
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg


class OverlayPublisher:
    """Publishes a node's overlay.

    Parameters
    ----------
    endpoints : WatchedEndpoints
        Creates the publishers.
    compressed : NodeTopic
        Topic of the JPEG.
    """

    def __init__(self, endpoints: WatchedEndpoints, compressed: NodeTopic) -> None:
        self._raw, self._compressed = (
            endpoints.publisher(topic, qos.PICTURES, topic.of_node("~"))
            for topic in (node_topics.RAW_OVERLAY, compressed)
        )

    @property
    def is_wanted(self) -> bool:
        """Whether a node listens to either topic."""
        return bool(self._raw.get_subscription_count() or self._compressed.get_subscription_count())

    def publish(self, header: Message, picture: Picture) -> None:
        """Publish a picture, blue-green-red, shape (H, W, 3), as it is subscribed to."""
        if self._raw.get_subscription_count():
            raw = raw_from_array(picture, "bgr8")
            self._raw.publish(make_image(MESSAGES, raw, header))
        if self._compressed.get_subscription_count():
            jpeg = make_compressed_image(MESSAGES, encode_jpeg(picture), header)
            self._compressed.publish(jpeg)
