"""Properties of the node that is soaked: the tracker of cables or of targets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from geometry_msgs.msg import PoseWithCovarianceStamped

from cable_tracker.followed_kinds import CABLE, TARGET, FollowedKind
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.target import make_polygon
from cable_tracker.sequences.node_topics import CABLE_TOPICS, TARGET_TOPICS, TrackerTopics
from cable_tracker.tracking.parameter_table import ParameterSet


@dataclass(frozen=True, slots=True)
class SoakedNode:
    """A node that is soaked.

    Attributes
    ----------
    kind : FollowedKind
        Its name and its parameters.
    topics : TrackerTopics
        Its topics.
    claimed : str
        What it claims.
    start : mapping
        Parameters that it is started with, beside the usual ones.
    bad_start : callable
        Returns a spoilt message that says where to start, with a header.
    """

    kind: FollowedKind[ParameterSet]
    topics: TrackerTopics
    claimed: str
    start: Mapping[str, str]
    bad_start: Callable[[Message, np.random.Generator], Message]


def _bad_prior(header: Message, rng: np.random.Generator) -> Message:
    prior = PoseWithCovarianceStamped()
    prior.header = header
    prior.pose.pose.position.x = float(rng.choice([np.nan, np.inf, 1e308, 0.0]))
    prior.pose.covariance = rng.choice([np.nan, -1.0, 0.0, 1e300], 36).astype(np.float64)
    return prior


def _bad_outline(header: Message, rng: np.random.Generator) -> Message:
    """Mark what no picture can hold, or what nothing stands out of."""
    count = int(rng.integers(0, 6))
    corners = rng.choice([np.nan, np.inf, -1e30, 0.0, 5.0, 40.0, 1e6], (count, 2))
    return make_polygon(MESSAGES, header, corners)


CABLE_NODE = SoakedNode(
    kind=CABLE,
    topics=CABLE_TOPICS,
    claimed="cable",
    start={},
    bad_start=_bad_prior,
)

TARGET_NODE = SoakedNode(
    kind=TARGET,
    topics=TARGET_TOPICS,
    claimed="target",
    start={"initial_target": "detect", "detector": "contours"},
    bad_start=_bad_outline,
)

SOAKED: Mapping[str, SoakedNode] = {each.kind.node: each for each in (CABLE_NODE, TARGET_NODE)}
"""Soaked nodes by name."""
