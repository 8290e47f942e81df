"""Messages in pixels about one frame of a target: which there are, and how each is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message, MessageFactory, MessageMakers
from cable_tracker.sequences.messages.frame_report import make_report
from cable_tracker.sequences.messages.target import (
    make_polygon,
    make_target,
    make_target_markers,
    make_target_particles,
    make_target_state,
    target_report_values,
)
from cable_tracker.target.model.estimate import TargetEstimate, box_corners


def target_messages(
    factory: MessageFactory,
    header: Message,
    estimate: TargetEstimate,
    particles: Particles | None,
    *,
    ms: float,
    metres: Callable[[], Mapping[str, str]],
) -> MessageMakers:
    """Return what makes the messages about a frame that was used, but for its overlay.

    Parameters
    ----------
    header : Message
        Stamp and frame of the image.
    estimate : TargetEstimate
        Estimate of the frame [px, rad].
    particles : Particles or None
        Particles after the frame, lengths in pixels of it; None before the first target.
    ms : float
        Time the tracker took [ms].
    metres : callable
        Returns what the report says in metres, see `target_facts`; called when the report is made.
    """

    def make_frame_report() -> Message:
        count = particles.count if particles is not None else 0
        values = target_report_values(estimate, ms, count) | dict(metres())
        return make_report(factory, header, estimate.status.value, values)

    makers: MessageMakers = {
        node_topics.STATE: lambda: make_target_state(factory, header, estimate),
        node_topics.TARGET_REPORT: make_frame_report,
    }
    box = estimate.box
    if estimate.is_claimed and box is not None:
        makers[node_topics.TARGET] = lambda: make_target(factory, header, estimate)
        makers[node_topics.BOX] = lambda: make_polygon(factory, header, box_corners(box))
        if len(estimate.outline):
            makers[node_topics.CONTOUR] = lambda: make_polygon(factory, header, estimate.outline)
    if particles is not None:
        makers[node_topics.PARTICLES] = lambda: make_target_particles(factory, header, particles)
    makers[node_topics.MARKERS] = lambda: make_target_markers(factory, header, estimate)
    return makers


def messages_without_target(
    factory: MessageFactory, header: Message, status: str, reason: str
) -> MessageMakers:
    """Return what makes the messages about a frame without an estimate, by status and reason."""
    return {
        node_topics.STATE: lambda: make_target_state(factory, header, None),
        node_topics.TARGET_REPORT: lambda: make_report(factory, header, status, {"event": reason}),
    }
