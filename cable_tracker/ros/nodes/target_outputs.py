"""Messages of the target tracker about its targets. Pictures are built only for subscribers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from cable_tracker.arrays import FloatArray
from cable_tracker.arrays import Image as Picture
from cable_tracker.metric.targets.relative_state import RelativeState
from cable_tracker.metric.targets.target_facts import target_facts
from cable_tracker.metric.targets.target_metres import TargetMetres
from cable_tracker.metric.withheld import Withheld
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.ros import qos
from cable_tracker.ros.health.watched_endpoints import WatchedPublishers
from cable_tracker.ros.messages.rclpy_messages import RclpyMessages
from cable_tracker.ros.nodes.overlay_publisher import OverlayPublisher
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.frame_report import make_report
from cable_tracker.sequences.messages.headers import make_header, stamp_of
from cable_tracker.sequences.messages.target import (
    make_bearing,
    make_polygon,
    make_relative_pose,
    make_target,
    make_target_state,
    target_report_values,
)
from cable_tracker.sequences.messages.target_markers import make_target_markers
from cable_tracker.sequences.messages.target_particles import make_target_particles
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.sequences.pictures.shown_levels import shown_levels
from cable_tracker.target.model.estimate import TargetEstimate, box_corners
from cable_tracker.visualisation.target_overlay import draw_target


@dataclass(frozen=True, slots=True, eq=False)
class TargetAnswer:
    """Results of a frame for one target.

    Attributes
    ----------
    estimate : TargetEstimate
        Estimate in pixels.
    metres : TargetMetres
        Estimate in metres, or the reason for none.
    particles : Particles or None
        Particles, lengths in pixels of the frame.
    """

    estimate: TargetEstimate
    metres: TargetMetres
    particles: Particles | None


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
        self._factory = RclpyMessages()

        def create(topic: NodeTopic, profile: QoSProfile) -> Publisher:
            return publishers.create(topic, profile, f"{prefix}{topic.name}")

        self._state = create(node_topics.STATE, qos.LATEST_RESULT)
        self._target = create(node_topics.TARGET, qos.RESULTS)
        self._contour = create(node_topics.CONTOUR, qos.RESULTS)
        self._box = create(node_topics.BOX, qos.RESULTS)
        self._bearing = create(node_topics.BEARING, qos.RESULTS)
        self._relative = create(node_topics.RELATIVE_POSE, qos.RESULTS)
        self._particles = create(node_topics.PARTICLES, qos.PICTURES)
        self._markers = create(node_topics.MARKERS, qos.PICTURES)

    def publish_results(
        self, header: Message, answer: TargetAnswer, base_frame: str, camera_place: FloatArray
    ) -> None:
        """Publish what is claimed: centre, outline, bearing, range."""
        estimate, metres, factory = answer.estimate, answer.metres, self._factory
        if not estimate.is_claimed:
            return
        if self._target.get_subscription_count():
            self._target.publish(make_target(factory, header, estimate))
        if self._box.get_subscription_count() and estimate.box is not None:
            self._box.publish(make_polygon(factory, header, box_corners(estimate.box)))
        if self._contour.get_subscription_count() and len(estimate.outline):
            self._contour.publish(make_polygon(factory, header, estimate.outline))
        if not isinstance(metres.ray, Withheld) and self._bearing.get_subscription_count():
            self._bearing.publish(make_bearing(factory, header, metres.ray))
        if isinstance(metres.relative, RelativeState) and self._relative.get_subscription_count():
            place = metres.relative.position() + camera_place
            covariance = metres.relative.position_covariance()
            own_header = make_header(factory, stamp_of(header), base_frame)
            self._relative.publish(make_relative_pose(factory, own_header, place, covariance))

    def publish_pictures(self, header: Message, answer: TargetAnswer) -> None:
        """Publish what people look at."""
        if answer.particles is not None and self._particles.get_subscription_count():
            self._particles.publish(make_target_particles(self._factory, header, answer.particles))
        if self._markers.get_subscription_count():
            self._markers.publish(make_target_markers(self._factory, header, answer.estimate))

    def publish_state(self, header: Message, estimate: TargetEstimate | None) -> None:
        """Publish the state: always, because a subscriber that joins later may ask for it."""
        self._state.publish(make_target_state(self._factory, header, estimate))


class TargetOutputs:
    """The publishers of all targets, but for the node's diagnostics.

    Parameters
    ----------
    publishers : WatchedPublishers
        Creates them.
    prefixes : sequence of str
        Prefixes of the topics of each target.
    """

    def __init__(self, publishers: WatchedPublishers, prefixes: Sequence[str]) -> None:
        self._factory = RclpyMessages()
        self._targets = [OneTarget(publishers, prefix) for prefix in prefixes]
        self._overlay = OverlayPublisher(publishers, node_topics.TARGET_OVERLAY)
        self._report = publishers.create(
            node_topics.TARGET_REPORT, qos.RESULTS, node_topics.TARGET_REPORT.of_node("~")
        )

    def answer_without_estimate(self, header: Message, status: str, reason: str) -> None:
        """Publish that there is no estimate for this frame; every frame gets an answer."""
        if self._report.get_subscription_count():
            values = {"event": reason}
            reports = [make_report(self._factory, header, status, values) for _ in self._targets]
            self._publish_report(reports)
        for target in self._targets:
            target.publish_state(header, None)

    def publish_results(
        self,
        header: Message,
        answers: Sequence[TargetAnswer],
        base_frame: str,
        camera_place: FloatArray,
    ) -> None:
        """Publish what is claimed.

        Parameters
        ----------
        header : Message
            Stamp and frame of the image.
        answers : sequence of TargetAnswer
            Answers for the frame, one for each target.
        base_frame : str
            Frame of what is in metres.
        camera_place : FloatArray
            Position of the camera in base_link, shape (3,) [m].
        """
        for target, answer in zip(self._targets, answers, strict=True):
            target.publish_results(header, answer, base_frame, camera_place)

    def publish_pictures(
        self, header: Message, answers: Sequence[TargetAnswer], picture: Picture
    ) -> None:
        """Publish what people look at; `picture` is blue-green-red, with levels 0..255."""
        for target, answer in zip(self._targets, answers, strict=True):
            target.publish_pictures(header, answer)
        if not self._overlay.is_wanted:
            return
        drawn = shown_levels(picture)
        for line, answer in enumerate(answers):
            states = answer.particles.states if answer.particles is not None else None
            drawn = draw_target(drawn, answer.estimate, states, line=line)
        self._overlay.publish(header, drawn)

    def publish_states(
        self,
        header: Message,
        answers: Sequence[TargetAnswer],
        milliseconds: float,
        camera_place: FloatArray,
    ) -> None:
        """Publish reports and states; last, because a lockstep replay goes on upon a state.

        Parameters
        ----------
        header : Message
            Stamp and frame of the image.
        answers : sequence of TargetAnswer
            Answers for the frame, one for each target.
        milliseconds : float
            Processing time of the frame [ms].
        camera_place : FloatArray
            Position of the camera in base_link, shape (3,) [m].
        """
        if self._report.get_subscription_count():
            self._publish_report(
                [
                    make_report(
                        self._factory,
                        header,
                        answer.estimate.status.value,
                        target_report_values(
                            answer.estimate,
                            milliseconds,
                            answer.particles.count if answer.particles is not None else 0,
                        )
                        | target_facts(answer.metres, camera_place),
                    )
                    for answer in answers
                ]
            )
        for target, answer in zip(self._targets, answers, strict=True):
            target.publish_state(header, answer.estimate)

    def _publish_report(self, reports: list[Message]) -> None:
        """Publish one message with the entries of all targets, in their order."""
        first, *others = reports
        first.status = [*first.status, *(entry for each in others for entry in each.status)]
        self._report.publish(first)
