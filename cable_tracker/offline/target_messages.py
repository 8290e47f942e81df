"""Messages of the node about a frame of a target, for a bag."""

from __future__ import annotations

from collections.abc import Mapping

from cable_tracker.arrays import Image
from cable_tracker.metric.recorded.recorded_target import RecordedSight
from cable_tracker.metric.targets.relative_state import RelativeState
from cable_tracker.metric.targets.target_metres import TargetMetres
from cable_tracker.metric.withheld import Withheld
from cable_tracker.offline.frame_messages import FrameMessages
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.frame_report import make_report
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.images import make_compressed_image
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
from cable_tracker.sequences.pictures.encoded_pictures import encode_jpeg
from cable_tracker.target.model.estimate import TargetEstimate, box_corners
from cable_tracker.tracking.status_words import REFUSED


class TargetMessages(FrameMessages):
    """Writes the messages that the node would publish about one frame."""

    def write_refusal(self, reason: str) -> None:
        """Write that there is no estimate."""
        factory, header = self._factory, self._header
        self._write(node_topics.STATE, make_target_state(factory, header, None))
        report = make_report(factory, header, REFUSED, {"event": reason})
        self._write(node_topics.TARGET_REPORT, report)

    def write_estimate(
        self,
        estimate: TargetEstimate,
        particles: Particles | None,
        picture: Image,
        ms: float,
        facts: Mapping[str, str],
    ) -> None:
        """Write everything in pixels about a frame that was used.

        Parameters
        ----------
        picture : Image
            Frame for the overlay, shape (H, W, 3), uint8.
        ms : float
            Time the tracker took [ms].
        facts : mapping
            Values of the report in metres, see `target_facts`.
        """
        factory, header = self._factory, self._header
        self._write(node_topics.STATE, make_target_state(factory, header, estimate))
        count = particles.count if particles is not None else 0
        values = target_report_values(estimate, ms, count) | dict(facts)
        report = make_report(factory, header, estimate.status.value, values)
        self._write(node_topics.TARGET_REPORT, report)
        if estimate.is_claimed and estimate.box is not None:
            self._write(node_topics.TARGET, make_target(factory, header, estimate))
            corners = box_corners(estimate.box)
            self._write(node_topics.BOX, make_polygon(factory, header, corners))
            if len(estimate.outline):
                outline = make_polygon(factory, header, estimate.outline)
                self._write(node_topics.CONTOUR, outline)
        if particles is not None:
            cloud = make_target_particles(factory, header, particles)
            self._write(node_topics.PARTICLES, cloud)
        markers = make_target_markers(factory, header, estimate)
        self._write(node_topics.MARKERS, markers)
        jpeg = make_compressed_image(factory, encode_jpeg(picture), header)
        self._write(node_topics.TARGET_OVERLAY, jpeg)

    def write_metres(self, metres: TargetMetres, sight: RecordedSight) -> None:
        """Write bearing and place, as far as they are known."""
        factory = self._factory
        if not isinstance(metres.ray, Withheld):
            self._write(node_topics.BEARING, make_bearing(factory, self._header, metres.ray))
        if isinstance(metres.relative, RelativeState):
            place = metres.relative.position() + sight.settings.mounting.position
            header = make_header(factory, self._stamp, sight.base_frame)
            covariance = metres.relative.position_covariance()
            pose = make_relative_pose(factory, header, place, covariance)
            self._write(node_topics.RELATIVE_POSE, pose)
