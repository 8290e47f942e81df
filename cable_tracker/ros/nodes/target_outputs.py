"""Messages of the target tracker about its targets. Pictures are built only for subscribers."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from cable_tracker.arrays import Image as Picture
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publish_wanted
from cable_tracker.ros.health.watched_endpoints import WatchedPublishers
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.nodes.overlay_publisher import OverlayPublisher
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message, MessageMakers
from cable_tracker.sequences.messages.target import messages_without_target
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.sequences.pictures.shown_levels import shown_levels
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.visualisation.target_overlay import draw_target

RESULTS = (
    node_topics.TARGET, node_topics.BOX, node_topics.CONTOUR, node_topics.BEARING,
    node_topics.RELATIVE_POSE,
)  # fmt: skip
"""Topics of what is claimed, in the order of publishing."""

PICTURES = (node_topics.PARTICLES, node_topics.MARKERS)
"""Topics of what people look at, for each target."""


class OneTarget:
    """The publishers of one target.

    Parameters
    ----------
    publishers : WatchedPublishers
        Creates them.
    prefix : str
        Before the names of the topics: empty, or `target_0/`.
    """

    def __init__(self, publishers: WatchedPublishers, prefix: str) -> None:
        def create(topic: NodeTopic, profile: QoSProfile) -> Publisher:
            return publishers.create(topic, profile, f"{prefix}{topic.name}")

        self._state = create(node_topics.STATE, qos.LATEST_RESULT)
        self._wanted = {topic: create(topic, qos.RESULTS) for topic in RESULTS}
        self._wanted |= {topic: create(topic, qos.PICTURES) for topic in PICTURES}

    def publish(self, makers: MessageMakers, topics: Sequence[NodeTopic]) -> None:
        """Publish on some topics what is subscribed to."""
        publish_wanted(self._wanted, makers, *topics)

    def publish_state(self, makers: MessageMakers) -> None:
        """Publish the state: always, because a subscriber that joins later may ask for it."""
        self._state.publish(makers[node_topics.STATE]())


class TargetOutputs:
    """The publishers of all targets, but for the node's diagnostics.

    What is published of a frame is handed over as one `MessageMakers` for each target.

    Parameters
    ----------
    publishers : WatchedPublishers
        Creates them.
    prefixes : sequence of str
        Prefixes of the topics of each target.
    """

    def __init__(self, publishers: WatchedPublishers, prefixes: Sequence[str]) -> None:
        self._targets = [OneTarget(publishers, prefix) for prefix in prefixes]
        self._overlay = OverlayPublisher(publishers, node_topics.TARGET_OVERLAY)
        self._report = publishers.create(
            node_topics.TARGET_REPORT, qos.RESULTS, node_topics.TARGET_REPORT.of_node("~")
        )

    def answer_without_estimate(self, header: Message, status: str, reason: str) -> None:
        """Publish that there is no estimate for this frame; every frame gets an answer."""
        makers = messages_without_target(MESSAGES, header, status, reason)
        self._publish_states([makers] * len(self._targets))

    def publish_results(self, makers: Sequence[MessageMakers]) -> None:
        """Publish what is claimed: centre, outline, bearing, range."""
        for target, own in zip(self._targets, makers, strict=True):
            target.publish(own, RESULTS)

    def publish_rest(
        self,
        makers: Sequence[MessageMakers],
        header: Message,
        estimates: Sequence[TargetEstimate],
        particles: Sequence[Particles | None],
        picture: Picture,
    ) -> None:
        """Publish what people look at, and last the states."""
        for target, own in zip(self._targets, makers, strict=True):
            target.publish(own, PICTURES)
        self._publish_overlay(header, estimates, particles, picture)
        self._publish_states(makers)

    def _publish_overlay(
        self,
        header: Message,
        estimates: Sequence[TargetEstimate],
        particles: Sequence[Particles | None],
        picture: Picture,
    ) -> None:
        """Publish the frame with all targets drawn; it is blue-green-red, with levels 0..255."""
        if not self._overlay.is_wanted:
            return
        drawn = shown_levels(picture)
        for line, (estimate, cloud) in enumerate(zip(estimates, particles, strict=True)):
            states = cloud.states if cloud is not None else None
            drawn = draw_target(drawn, estimate, states, line=line)
        self._overlay.publish(header, drawn)

    def _publish_states(self, makers: Sequence[MessageMakers]) -> None:
        """Publish report and states; last, because a lockstep replay goes on upon a state.

        The report is one message with the entries of all targets, in their order.
        """
        if self._report.get_subscription_count():
            first, *others = [own[node_topics.TARGET_REPORT]() for own in makers]
            first.status = [*first.status, *(entry for each in others for entry in each.status)]
            self._report.publish(first)
        for target, own in zip(self._targets, makers, strict=True):
            target.publish_state(own)
