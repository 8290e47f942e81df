"""Messages of the tracker node about frames. Pictures are built only for subscribers."""

from __future__ import annotations

from cable_tracker.arrays import Image as Picture
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publish_wanted
from cable_tracker.ros.health.watched_endpoints import WatchedPublishers
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.nodes.overlay_publisher import OverlayPublisher
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.cable import cloud_of, messages_without_cable
from cable_tracker.sequences.messages.factory import Message, MessageMakers
from cable_tracker.visualisation.overlay import draw_estimate


class TrackerOutputs:
    """The node's publishers, but for its diagnostics.

    Parameters
    ----------
    publishers : WatchedPublishers
        Creates them.
    """

    def __init__(self, publishers: WatchedPublishers) -> None:
        create = publishers.create
        report = node_topics.FRAME_REPORT
        self._state = create(node_topics.STATE, qos.LATEST_RESULT)
        self._wanted = {
            node_topics.CENTRELINE: create(node_topics.CENTRELINE, qos.RESULTS),
            node_topics.PARTICLES: create(node_topics.PARTICLES, qos.PICTURES),
            node_topics.MARKERS: create(node_topics.MARKERS, qos.PICTURES),
            report: create(report, qos.RESULTS, report.of_node("~")),
        }
        self._overlay = OverlayPublisher(publishers, node_topics.OVERLAY)

    def answer_without_estimate(self, header: Message, status: str, reason: str) -> None:
        """Publish that there is no estimate for this frame; every frame gets an answer."""
        self._publish_state(messages_without_cable(MESSAGES, header, status, reason))

    def publish_centreline(self, makers: MessageMakers) -> None:
        """Publish where the cable runs, if one is claimed."""
        publish_wanted(self._wanted, makers, node_topics.CENTRELINE)

    def publish_rest(
        self,
        makers: MessageMakers,
        header: Message,
        estimate: CableEstimate,
        particles: Particles | None,
        grey: Picture,
    ) -> None:
        """Publish what people look at, and last the state."""
        publish_wanted(self._wanted, makers, node_topics.PARTICLES, node_topics.MARKERS)
        if self._overlay.is_wanted:
            cloud = cloud_of(particles) if particles is not None else None
            self._overlay.publish(header, draw_estimate(grey, estimate, cloud))
        self._publish_state(makers)

    def _publish_state(self, makers: MessageMakers) -> None:
        """Publish report and state.

        The state goes last, because a lockstep replay sends the next frame upon it, and always,
        because a subscriber that joins later may ask for it.
        """
        publish_wanted(self._wanted, makers, node_topics.FRAME_REPORT)
        self._state.publish(makers[node_topics.STATE]())
