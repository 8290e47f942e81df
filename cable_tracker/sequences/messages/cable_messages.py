"""Messages about one frame of a tracked cable: which there are, and how each is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.cable import (
    cloud_of,
    make_centreline,
    make_markers,
    make_particles,
    make_state,
    report_values,
)
from cable_tracker.sequences.messages.factory import Message, MessageFactory, MessageMakers
from cable_tracker.sequences.messages.frame_report import make_report


def cable_messages(
    factory: MessageFactory,
    header: Message,
    estimate: CableEstimate,
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
    estimate : CableEstimate
        Estimate of the frame [px, rad].
    particles : Particles or None
        Particles after the frame; None: the filter has none.
    ms : float
        Time the tracker took [ms].
    metres : callable
        Returns what the report says in metres, see `cable_facts`; called when the report is made.
    """
    claimed = estimate.claimed_state

    def make_frame_report() -> Message:
        values = report_values(estimate, ms) | dict(metres())
        return make_report(factory, header, estimate.status.value, values)

    makers: MessageMakers = {
        node_topics.STATE: lambda: make_state(
            factory, header, claimed, estimate.standard_deviations()[:4]
        ),
        node_topics.FRAME_REPORT: make_frame_report,
    }
    if claimed is not None:
        makers[node_topics.CENTRELINE] = lambda: make_centreline(
            factory, header, claimed, estimate.covariance
        )
    if particles is not None:
        makers[node_topics.PARTICLES] = lambda: make_particles(factory, header, cloud_of(particles))
    makers[node_topics.MARKERS] = lambda: make_markers(
        factory, header, claimed, estimate.image_size
    )
    return makers


def messages_without_cable(
    factory: MessageFactory, header: Message, status: str, reason: str
) -> MessageMakers:
    """Return what makes the messages about a frame without an estimate, by status and reason."""
    return {
        node_topics.STATE: lambda: make_state(factory, header, None),
        node_topics.FRAME_REPORT: lambda: make_report(factory, header, status, {"event": reason}),
    }
