"""What the node of a tracker publishes of a frame. Messages are made only for subscribers."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cable_tracker.arrays import Image as Picture
from cable_tracker.ros import qos
from cable_tracker.ros.health.watched_endpoints import WatchedEndpoints
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.messages.factory import Message, MessageFactory, MessageMakers
from cable_tracker.sequences.messages.images import make_compressed_image, make_image
from cable_tracker.sequences.node_topics import NodeTopic, TrackerTopics
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg

PICTURES = (node_topics.PARTICLES, node_topics.MARKERS)
"""Topics of what people look at, beside the overlay."""


class FrameOutputs:
    """The node's publishers, but for diagnostics.

    What is published of a frame is handed over as one `MessageMakers` for each prefix.

    Parameters
    ----------
    endpoints : WatchedEndpoints
        Creates them.
    topics : TrackerTopics
        Topics of the tracker.
    without_estimate : callable
        Makes, from header, status and reason, what is published without an estimate.
    claims : sequence of NodeTopic
        Topics of what is claimed, in the order of publishing.
    prefixes : sequence of str
        What stands before the names of the topics of each cable or target, such as `target_0/`.
    """

    def __init__(
        self,
        endpoints: WatchedEndpoints,
        topics: TrackerTopics,
        without_estimate: Callable[[MessageFactory, Message, str, str], MessageMakers],
        claims: Sequence[NodeTopic],
        prefixes: Sequence[str] = ("",),
    ) -> None:
        self._topics = topics
        self._without_estimate = without_estimate
        self._claims = claims
        profiles = dict.fromkeys(claims, qos.RESULTS) | dict.fromkeys(PICTURES, qos.PICTURES)
        self._wanted = [
            {
                topic: endpoints.publisher(topic, profile, f"{prefix}{topic.name}")
                for topic, profile in profiles.items()
            }
            for prefix in prefixes
        ]
        state = node_topics.STATE
        self._states = [
            endpoints.publisher(state, qos.LATEST_RESULT, f"{prefix}{state.name}")
            for prefix in prefixes
        ]
        self._overlay, self._overlay_jpeg = (
            endpoints.publisher(topic, qos.PICTURES, topic.of_node("~"))
            for topic in (node_topics.RAW_OVERLAY, topics.overlay)
        )
        self._report = endpoints.publisher(topics.report, qos.RESULTS, topics.report.of_node("~"))

    def answer_without_estimate(self, header: Message, status: str, reason: str) -> None:
        """Publish that there is no estimate for this frame; every frame gets an answer."""
        makers = self._without_estimate(MESSAGES, header, status, reason)
        self._publish_states([makers] * len(self._states))

    def publish_results(self, makers: Sequence[MessageMakers]) -> None:
        """Publish what is claimed, if anything is."""
        self._publish_wanted(makers, self._claims)

    def publish_rest(
        self, makers: Sequence[MessageMakers], header: Message, draw: Callable[[], Picture]
    ) -> None:
        """Publish what people look at, and last the states.

        Parameters
        ----------
        makers : sequence of dict
            Make the messages.
        header : Message
            Header of the overlay.
        draw : callable
            Draws the overlay, blue-green-red, shape (H, W, 3).
        """
        self._publish_wanted(makers, PICTURES)
        self._publish_overlay(header, draw)
        self._publish_states(makers)

    def _publish_wanted(self, makers: Sequence[MessageMakers], topics: Sequence[NodeTopic]) -> None:
        """Publish what there is of some topics, in their order, where they have subscribers."""
        for publishers, own in zip(self._wanted, makers, strict=True):
            for topic in topics:
                if topic in own and publishers[topic].get_subscription_count():
                    publishers[topic].publish(own[topic]())

    def _publish_overlay(self, header: Message, draw: Callable[[], Picture]) -> None:
        """Draw the overlay once, and publish it raw and as JPEG, as it is subscribed to."""
        wants_raw = self._overlay.get_subscription_count()
        wants_jpeg = self._overlay_jpeg.get_subscription_count()
        if not (wants_raw or wants_jpeg):
            return
        picture = draw()
        if wants_raw:
            self._overlay.publish(make_image(MESSAGES, raw_from_array(picture, "bgr8"), header))
        if wants_jpeg:
            jpeg = make_compressed_image(MESSAGES, encode_jpeg(picture), header)
            self._overlay_jpeg.publish(jpeg)

    def _publish_states(self, makers: Sequence[MessageMakers]) -> None:
        """Publish report and states.

        The report is one message with the entries of all, in their order. The states go last,
        because a lockstep replay sends the next frame upon one, and always, because a subscriber
        that joins later may ask for it.
        """
        if self._report.get_subscription_count():
            first, *others = [own[self._topics.report]() for own in makers]
            first.status = [*first.status, *(entry for each in others for entry in each.status)]
            self._report.publish(first)
        for publisher, own in zip(self._states, makers, strict=True):
            publisher.publish(own[node_topics.STATE]())
