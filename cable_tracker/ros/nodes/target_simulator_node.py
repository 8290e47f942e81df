"""The simulated vehicle behind a target: `cmd_vel` in; camera, instruments and truth out."""

from __future__ import annotations

from typing import Any

import numpy as np
from rclpy.publisher import Publisher

from cable_tracker.node_parameter_tables import VehicleNodeParameters
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publisher
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.nodes.vehicle_node import VehicleNode
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import RawImage
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE
from cable_tracker.sequences.messages.target import make_relative_pose
from cable_tracker.simulation.instruments.instrument_messages import BASE
from cable_tracker.simulation.targets.chase import ChaseSettings, ChaseView, ChaseWorld
from cable_tracker.simulation.vehicle import VehicleState


class TargetSimulatorNode(VehicleNode[ChaseWorld, VehicleNodeParameters]):
    """Tows a red float before a vehicle's camera; clouds of silt hide it now and then.

    `ground_truth/target` has a variance of 1e6 while nothing of it can be seen.

    Parameters
    ----------
    **node_arguments
        Passed on to `rclpy.node.Node`: context, namespace, parameter_overrides, ...

    Raises
    ------
    ParameterError
        A parameter is not acceptable.
    """

    def __init__(self, **node_arguments: Any) -> None:  # noqa: ANN401
        self._view: ChaseView | None = None
        super().__init__(
            "target_simulator",
            ChaseWorld,
            ChaseSettings(),
            VehicleNodeParameters(),
            **node_arguments,
        )

    def _create_topics(self) -> None:
        super()._create_topics()
        self._true_target = publisher(self, node_topics.TRUE_TARGET, qos.RESULTS)

    def _draw(self, state: VehicleState) -> RawImage:
        self._view = self._world.view(state)
        return raw_from_array(self._view.image, "bgr8")

    def _publish_truth(self, state: VehicleState, stamp: int) -> None:
        assert self._view is not None
        header = make_header(MESSAGES, stamp, BASE)
        # What is out of view has a position, too; its variance says that it cannot be seen.
        variance = 0.0 if self._view.mask.any() else UNKNOWN_VARIANCE
        self._true_target.publish(
            make_relative_pose(MESSAGES, header, self._view.place, np.eye(3) * variance)
        )

    def _is_at_end(self, state: VehicleState) -> bool:
        return self._world.time >= self._world.settings.duration

    def _last_publishers(self) -> tuple[Publisher, ...]:
        return (self._true_target,)
