"""Quality of service of our topics."""

from __future__ import annotations

from typing import Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

RELIABILITIES = {
    "best_effort": ReliabilityPolicy.BEST_EFFORT,
    "reliable": ReliabilityPolicy.RELIABLE,
}


def image_input(reliability: str) -> QoSProfile:
    """Return the profile of the image subscription.

    Best effort takes the newest frame only: a tracker that is late must not work through a queue.
    Reliable keeps a few, for a lockstep replay that must not lose any.
    """
    depth = 1 if reliability == "best_effort" else 10
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST, depth=depth, reliability=RELIABILITIES[reliability]
    )


def instrument_input(reliability: str) -> QoSProfile:
    """Return the profile of the subscriptions to the vehicle's instruments.

    A few are kept: several come between two frames, and each counts. Reliable keeps more, for a
    replay that sends at once what was said before its first frame.
    """
    depth = 20 if reliability == "best_effort" else INSTRUMENTS_KEPT
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST, depth=depth, reliability=RELIABILITIES[reliability]
    )


INSTRUMENTS_KEPT = 1000

INSTRUMENTS = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=INSTRUMENTS_KEPT,
    reliability=ReliabilityPolicy.RELIABLE,
)
"""Quality of service with which a replay sends the vehicle's instruments."""

LATCHED = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=100,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""`/tf_static`, and a calibration that was sent once: subscribers that come later get it too."""

RESULTS = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=50, reliability=ReliabilityPolicy.RELIABLE
)
"""Small results: every frame's."""

LATEST_RESULT = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=50,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""`state`: a subscriber that joins while frames pause gets the last answers at once if it asks."""

PICTURES = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=5, reliability=ReliabilityPolicy.RELIABLE
)
"""Pictures for people: rviz and recorders read them reliably or not, as they like."""

NEWEST_RESULT = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
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
