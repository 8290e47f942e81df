"""Properties of the node that is soaked: the tracker of cables or of targets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from geometry_msgs.msg import PoseWithCovarianceStamped

from cable_tracker.cable.parameters.parameters import PARAMETER_TABLE
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.rigs.soak.checks import (
    Check,
    centreline_is_finite,
    cloud_is_finite,
    points_are_finite,
    polygon_is_finite,
)
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.sequences.messages.target import make_polygon
from cable_tracker.sequences.node_topics import NodeTopic
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.target.parameters.presets import target_preset
from cable_tracker.tracking.parameter_table import ParameterSet, ParameterSpec, parameter_table


@dataclass(frozen=True, slots=True)
class SoakedNode:
    """A node that is soaked.

    Attributes
    ----------
    name : str
        Name of the node.
    what : str
        It claims.
    table : tuple of ParameterSpec
        Parameters for storms.
    preset : callable
        Returns a preset by its name.
    start : mapping
        Parameters that it is started with, beside the usual ones.
    mark : NodeTopic
        Its messages say where to start.
    bad_mark : callable
        Returns a spoilt mark of a header.
    heard : tuple of (NodeTopic, Check)
        Topics of results, and how their numbers are looked at.
    """

    name: str
    what: str
    table: tuple[ParameterSpec, ...]
    preset: Callable[[str], ParameterSet]
    start: Mapping[str, str]
    mark: NodeTopic
    bad_mark: Callable[[Message, np.random.Generator], Message]
    heard: tuple[tuple[NodeTopic, Check], ...]


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
    name="tracker",
    what="cable",
    table=PARAMETER_TABLE,
    preset=preset,
    start={},
    mark=node_topics.INITIAL_STATE,
    bad_mark=_bad_prior,
    heard=(
        (node_topics.CENTRELINE, centreline_is_finite),
        (node_topics.PARTICLES, cloud_is_finite),
    ),
)

TARGET_NODE = SoakedNode(
    name="target_tracker",
    what="target",
    table=parameter_table(TargetParameters),
    preset=target_preset,
    start={"initial_target": "detect", "detector": "contours"},
    mark=node_topics.INITIAL_TARGET,
    bad_mark=_bad_outline,
    heard=(
        (node_topics.TARGET, centreline_is_finite),
        (node_topics.CONTOUR, polygon_is_finite),
        (node_topics.BOX, polygon_is_finite),
        (node_topics.PARTICLES, points_are_finite),
    ),
)

SOAKED: Mapping[str, SoakedNode] = {each.name: each for each in (CABLE_NODE, TARGET_NODE)}
"""Soaked nodes by name."""
