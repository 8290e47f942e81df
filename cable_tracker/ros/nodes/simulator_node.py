"""The simulator of a cable: `cmd_vel` in, a vehicle's camera, instruments and truth out."""

from __future__ import annotations

from typing import Any

import numpy as np
from rclpy.publisher import Publisher

from cable_tracker.metric.messages import make_cross_track
from cable_tracker.node_parameter_tables import SimulatorNodeParameters
from cable_tracker.ros import qos
from cable_tracker.ros.endpoints import publisher
from cable_tracker.ros.messages.rclpy_messages import MESSAGES
from cable_tracker.ros.nodes.vehicle_node import VehicleNode
from cable_tracker.sequences import node_topics
from cable_tracker.sequences.encodings import raw_from_array
from cable_tracker.sequences.frame import RawImage
from cable_tracker.sequences.messages.cable import make_state
from cable_tracker.sequences.messages.headers import make_header
from cable_tracker.sequences.messages.poses import UNKNOWN_VARIANCE
from cable_tracker.simulation.instruments.instrument_messages import BASE, CAMERA, make_range
from cable_tracker.simulation.live_world import LiveSettings, LiveWorld
from cable_tracker.simulation.vehicle import VehicleState, VelocityCommand


class SimulatorNode(VehicleNode[LiveWorld, SimulatorNodeParameters]):
    """Lets a vehicle follow a cable.

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
        self._farthest = (0.0, 0.0)
        self._last_moved = 0.0
        super().__init__(
            "simulator", LiveWorld, LiveSettings(), SimulatorNodeParameters(), **node_arguments
        )

    @property
    def world(self) -> LiveWorld:
        """The world inside."""
        return self._world

    def _create_topics(self) -> None:
        super()._create_topics()
        self._range = publisher(self, node_topics.ALTITUDE, qos.RESULTS)
        self._true_state = publisher(self, node_topics.GROUND_TRUTH, qos.RESULTS)
        self._true_cross_track = publisher(self, node_topics.TRUE_CROSS_TRACK, qos.RESULTS)

    def _draw(self, state: VehicleState) -> RawImage:
        return raw_from_array(self._world.picture(state), "mono8")

    def _publish_altitude(self, stamp: int) -> None:
        header = make_header(MESSAGES, stamp, BASE)
        self._range.publish(make_range(MESSAGES, header, self._altitude))

    def _publish_truth(self, state: VehicleState, stamp: int) -> None:
        base_header = make_header(MESSAGES, stamp, BASE)
        camera_header = make_header(MESSAGES, stamp, CAMERA)
        cable = self._world.true_state(state)
        self._true_state.publish(make_state(MESSAGES, camera_header, cable))
        truth = self._world.cross_track(state)
        depth = self._world.cable_height - float(state.position[2])
        self._true_cross_track.publish(
            make_cross_track(
                MESSAGES,
                base_header,
                (0.0, truth.offset, depth),
                truth.heading,
                np.diag([UNKNOWN_VARIANCE, UNKNOWN_VARIANCE]),
            )
        )

    def _is_at_end(self, state: VehicleState) -> bool:
        truth = self._world.cross_track(state)
        farthest, since = self._farthest
        # Where a current carries a vehicle that stands still, it gets on, too, but to no purpose.
        is_driven = self._current_command() != VelocityCommand()
        if truth.along >= farthest + 1.0 and is_driven:
            self._farthest = (truth.along, self._world.time)
        is_stuck = self._world.time - since > self._own.patience
        return truth.along >= self._world.settings.length or is_stuck or self._stands_still()

    def _stands_still(self) -> bool:
        """Tell whether all commands have been zero for long."""
        if self._command != VelocityCommand():
            self._last_moved = self._world.time
        standstill = self._own.standstill
        return 0.0 < standstill < self._world.time - self._last_moved

    def _last_publishers(self) -> tuple[Publisher, ...]:
        return (self._true_cross_track,)
