"""Messages of the tracker node about frames. Pictures are built only for subscribers."""

from __future__ import annotations

from collections.abc import Mapping

from cable_tracker.arrays import Image as Picture
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.ros import qos
from cable_tracker.ros.health.watched_endpoints import WatchedPublishers
from cable_tracker.ros.messages.rclpy_messages import RclpyMessages
from cable_tracker.ros.nodes.overlay_publisher import OverlayPublisher
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.cable import make_centreline, make_state, report_values
from cable_tracker.sequences.messages.cable_markers import make_markers
from cable_tracker.sequences.messages.cable_particles import cloud_of, make_particles
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.frame_report import make_report
from cable_tracker.visualisation.overlay import draw_estimate


class TrackerOutputs:
    """The node's publishers, but for its diagnostics.

    Parameters
    ----------
    publishers : WatchedPublishers
        Creates them.
    """

    def __init__(self, publishers: WatchedPublishers) -> None:
        self._factory = RclpyMessages()
        create = publishers.create
        self._state = create(node_topics.STATE, qos.LATEST_RESULT)
        self._centreline = create(node_topics.CENTRELINE, qos.RESULTS)
        self._particles = create(node_topics.PARTICLES, qos.PICTURES)
        self._markers = create(node_topics.MARKERS, qos.PICTURES)
        self._overlay = OverlayPublisher(publishers, node_topics.OVERLAY)
        self._report = create(
            node_topics.FRAME_REPORT, qos.RESULTS, node_topics.FRAME_REPORT.of_node("~")
        )

    def answer_without_estimate(self, header: Message, status: str, reason: str) -> None:
        """Publish that there is no estimate for this frame; every frame gets an answer."""
        if self._report.get_subscription_count():
            self._report.publish(make_report(self._factory, header, status, {"event": reason}))
        self._state.publish(make_state(self._factory, header, None))

    def publish_centreline(self, header: Message, estimate: CableEstimate) -> None:
        """Publish where the cable runs, if one is claimed."""
        if not self._centreline.get_subscription_count():
            return
        claimed = estimate.claimed_state
        if claimed is not None:
            self._centreline.publish(
                make_centreline(self._factory, header, claimed, estimate.covariance)
            )

    def publish_pictures(
        self, header: Message, estimate: CableEstimate, particles: Particles | None, grey: Picture
    ) -> None:
        """Publish what people look at."""
        if particles is not None and self._particles.get_subscription_count():
            self._particles.publish(make_particles(self._factory, header, cloud_of(particles)))
        if self._markers.get_subscription_count():
            self._markers.publish(
                make_markers(self._factory, header, estimate.claimed_state, estimate.image_size)
            )
        if self._overlay.is_wanted:
            cloud = cloud_of(particles) if particles is not None else None
            self._overlay.publish(header, draw_estimate(grey, estimate, cloud))

    def publish_state(
        self,
        header: Message,
        estimate: CableEstimate,
        milliseconds: float,
        metres: Mapping[str, str],
    ) -> None:
        """Publish report, with what is known in metres, and state.

        The state goes last, because a lockstep replay sends the next frame upon it, and always,
        because a subscriber that joins later may ask for it.
        """
        if self._report.get_subscription_count():
            values = report_values(estimate, milliseconds) | dict(metres)
            self._report.publish(make_report(self._factory, header, estimate.status.value, values))
        sigma = estimate.standard_deviations()[:4]
        self._state.publish(make_state(self._factory, header, estimate.claimed_state, sigma))
