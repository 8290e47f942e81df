"""The part of the target tracker that knows the vehicle: calibration and motion in, metres out."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from rclpy.node import Node

from cable_tracker.metric.targets.relative_state import RelativeState
from cable_tracker.metric.targets.target_instrument_fusion import (
    TARGET_INSTRUMENTS,
    TargetInstrumentFusion,
)
from cable_tracker.metric.targets.target_metres import TargetMetres
from cable_tracker.metric.withheld import newly_withheld
from cable_tracker.node_parameter_tables import TargetVehicleParameters
from cable_tracker.ros.inputs.instrument_inputs import InstrumentInputs
from cable_tracker.target.model.estimate import TargetEstimate

REASON_PAUSE = 10.0
"""A reason for missing metres that comes sooner after another one is not told [s]."""


class TargetInputs(InstrumentInputs[TargetInstrumentFusion, TargetVehicleParameters]):
    """Listens to the instruments, and turns estimates into bearings and ranges.

    Parameters
    ----------
    node : Node
        The node.
    parameters : TargetVehicleParameters
        How the camera is mounted and read, and how large a target is, as the node has it at its
        start.
    count : int
        Number of targets.
    """

    def __init__(self, node: Node, parameters: TargetVehicleParameters, count: int) -> None:
        make_fusion = partial(TargetInstrumentFusion, count=count)
        super().__init__(node, parameters, make_fusion, TARGET_INSTRUMENTS)
        self._results: list[TargetMetres] = []

    def forget(self, number: int | None = None) -> None:
        """Begin anew with the range of one target, or of all."""
        self.fusion.forget(number)
        if number is None:
            self._results = []

    def take(self, estimates: Sequence[TargetEstimate]) -> Sequence[TargetMetres]:
        """Convert the estimates of a frame to metres; call it once for each frame."""
        before, self._results = self._results, self.fusion.take(estimates)
        for number, result in enumerate(self._results):
            self._log_reason(before[number] if number < len(before) else None, result)
        return self._results

    def figures(self, number: int) -> dict[str, str]:
        """Return the key-value pairs of diagnostics about a target's metres, units in the keys."""
        result = self._results[number] if number < len(self._results) else None
        relative = result.relative if result is not None else None
        known = relative if isinstance(relative, RelativeState) else None
        return {
            "range [m]": f"{known.range:.2f}" if known else "",
            "range sigma [m]": f"{known.range_sigma:.2f}" if known else "",
            "no metres": "" if known or relative is None else str(relative),
        }

    def _log_reason(self, before: TargetMetres | None, result: TargetMetres) -> None:
        """Log once why there are no metres, unless it is that no target is claimed."""
        news = newly_withheld(None if before is None else before.relative, result.relative)
        if news is not None:
            self._node.get_logger().info(
                f"no relative_pose: {news}", throttle_duration_sec=REASON_PAUSE
            )
