"""The part of the cable tracker's node that knows the vehicle: instruments in, metres out.

And odometry in, the vehicle's motion for the filter out.
"""

from __future__ import annotations

from rclpy.node import Node

from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.metric.cable_instrument_fusion import CABLE_INSTRUMENTS, CableInstrumentFusion
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.odometry.motion import Unaided
from cable_tracker.metric.withheld import Reason, Withheld, newly_withheld
from cable_tracker.node_parameter_tables import MOUNTING_PARAMETERS, CableVehicleParameters
from cable_tracker.ros import node_parameters
from cable_tracker.ros.inputs.instrument_inputs import InstrumentInputs
from cable_tracker.sequences.bags.instruments import Instrument

AWAITED = (Instrument.ALTITUDE, Instrument.IMU, Instrument.ODOMETRY)
"""Instruments for which a frame waits also before they have spoken."""

WARNING_PAUSE = 10.0
"""Odometry or an altimeter that fails again sooner is not warned of again [s]."""

ODOMETRY_ADVICE = "check the mounting parameters camera_*, and the stamps of odometry and images"

MOUNTING_NOT_GIVEN = (
    "the mounting of the camera was not given: cross_track takes it to look straight down at"
    f" base_link; set {', '.join(MOUNTING_PARAMETERS)} (camera_pitch: 90.0 says that it is so)"
)

NO_FRAME = Withheld(Reason.NOT_TRACKING, "no frame has come")


class CableInputs(InstrumentInputs[CableInstrumentFusion, CableVehicleParameters]):
    """Listens to the instruments, and turns estimates into metres.

    Parameters
    ----------
    node : Node
        The tracker node.
    parameters : CableVehicleParameters
        How camera and instruments are mounted and read, as the node has it at its start.

    Attributes
    ----------
    result : CrossTrack or Withheld
        Metres of the last frame.
    """

    def __init__(self, node: Node, parameters: CableVehicleParameters) -> None:
        super().__init__(node, parameters, CableInstrumentFusion, CABLE_INSTRUMENTS, AWAITED)
        self._is_mounting_checked = False
        self.result: CrossTrack | Withheld = NO_FRAME
        self._unaided: Unaided | None = None
        self._stand_in = ""

    def forget(self) -> None:
        """Forget the metres of the last frame; what the instruments have told stays."""
        self.result = NO_FRAME

    def take(self, estimate: CableEstimate) -> CrossTrack | Withheld:
        """Convert the estimate of a frame to metres; call it once for each frame."""
        self.fusion.observe(estimate)
        before, self.result = self.result, self.fusion.measure(estimate)
        self._warn_of_odometry()
        self._warn_of_stand_in(estimate.stamp)
        news = newly_withheld(before, self.result)
        if news is not None:
            self._node.get_logger().info(f"no cross_track: {news}")
        if isinstance(self.result, CrossTrack):
            self._warn_of_mounting()
        return self.result

    def _warn_of_odometry(self) -> None:
        """Warn where odometry begins to contradict what the camera sees."""
        before, self._unaided = self._unaided, self.fusion.aiding.unaided
        unaided = self._unaided
        if unaided is not None and unaided.disagrees and unaided != before:
            self._node.get_logger().warning(
                f"the filter goes on without odometry: {unaided.why}; {ODOMETRY_ADVICE}",
                throttle_duration_sec=WARNING_PAUSE,
            )

    def _warn_of_stand_in(self, stamp: int) -> None:
        """Warn where `fixed_altitude` begins to stand in: metres may jump then."""
        before, self._stand_in = self._stand_in, self.fusion.stand_in_at(stamp)
        if self._stand_in and not before:
            self._node.get_logger().warning(self._stand_in, throttle_duration_sec=WARNING_PAUSE)

    def _warn_of_mounting(self) -> None:
        """Warn with the first `cross_track` of a camera whose mounting was not given."""
        if self._is_mounting_checked:
            return
        self._is_mounting_checked = True
        defaults = CableVehicleParameters()
        if all(
            getattr(self.fusion.parameters, name) == getattr(defaults, name)
            and not node_parameters.is_given_at_start(self._node, name)
            for name in MOUNTING_PARAMETERS
        ):
            self._node.get_logger().warning(MOUNTING_NOT_GIVEN)

    def diagnostics(self) -> dict[str, str]:
        """Return the key-value pairs of diagnostics about metres, with units in the keys."""
        result, unaided = self.result, self.fusion.aiding.unaided
        known = result if isinstance(result, CrossTrack) else None
        return {
            "cross track [m]": f"{known.offset:.3f}" if known else "",
            "cable diameter [m]": f"{known.diameter:.3f}" if known else "",
            "no metres": "" if known else str(result),
            "no altimeter": self._stand_in,
            "no motion aid": "" if unaided is None else unaided.why,
            "odometry error [px]": self._odometry_error(),
        }

    def _odometry_error(self) -> str:
        """Return how far from the prediction the sea bed moved; empty if that is not known."""
        seen = self.fusion.aiding.texture_motion
        return f"{seen.error:.1f} of {seen.length:.1f}" if seen is not None else ""
