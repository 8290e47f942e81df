"""Quality of service of our topics."""

from __future__ import annotations

from typing import Any

from rclpy.duration import Infinite
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from cable_tracker.node_parameter_tables import BEST_EFFORT, RELIABLE

RELIABILITIES = {
    BEST_EFFORT: ReliabilityPolicy.BEST_EFFORT,
    RELIABLE: ReliabilityPolicy.RELIABLE,
}


def _newest(
    depth: int,
    reliability: ReliabilityPolicy = ReliabilityPolicy.RELIABLE,
    durability: DurabilityPolicy = DurabilityPolicy.VOLATILE,
) -> QoSProfile:
    """Return the profile that keeps so many messages, the newest."""
    # What is left at its default is zero here and infinite in the graph, as if it did not fit.
    return QoSProfile(
        deadline=Infinite,
        liveliness_lease_duration=Infinite,
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=reliability,
        durability=durability,
    )


def image_input(reliability: str) -> QoSProfile:
    """Return the profile of the image subscription.

    Best effort takes the newest frame only: a tracker that is late must not work through a queue.
    Reliable keeps a few, for a lockstep replay that must not lose any.
    """
    return _newest(1 if reliability == BEST_EFFORT else 10, RELIABILITIES[reliability])


def instrument_input(reliability: str) -> QoSProfile:
    """Return the profile of the subscriptions to the vehicle's instruments.

    A few are kept: several come between two frames, and each counts. Reliable keeps more, for a
    replay that sends at once what was said before its first frame.
    """
    depth = 20 if reliability == BEST_EFFORT else INSTRUMENTS_KEPT
    return _newest(depth, RELIABILITIES[reliability])


INSTRUMENTS_KEPT = 1000

INSTRUMENTS = _newest(INSTRUMENTS_KEPT)
"""Quality of service with which a replay sends the vehicle's instruments."""

LATCHED = _newest(100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""`/tf_static`, and a calibration that was sent once: subscribers that come later get it too."""

RESULTS = _newest(50)
"""Small results: every frame's."""

LATEST_RESULT = _newest(50, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""`state`: a subscriber that joins while frames pause gets the last answers at once if it asks."""

PICTURES = _newest(5)
"""Pictures for people: rviz and recorders read them reliably or not, as they like."""

NEWEST_RESULT = _newest(1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Quality of service with which a lockstep replay reads `state`: also the answer that was given
before it was discovered."""

EVERYTHING = QoSProfile(
    history=HistoryPolicy.KEEP_ALL, depth=0, reliability=ReliabilityPolicy.RELIABLE
)
"""Quality of service with which a recorder reads."""


def keeps_for_later(offered: QoSProfile) -> bool:
    """Tell whether a publisher keeps messages for subscriptions like `LATCHED` that come later."""
    return bool(
        offered.durability == DurabilityPolicy.TRANSIENT_LOCAL
        and offered.reliability == ReliabilityPolicy.RELIABLE
    )


def endpoint_name(endpoint: Any) -> str:  # noqa: ANN401
    """Return the full name of the node of an endpoint that the graph tells of."""
    return f"{endpoint.node_namespace.rstrip('/')}/{endpoint.node_name}"
