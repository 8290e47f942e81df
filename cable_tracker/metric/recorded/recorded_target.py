"""Bearing and range of a target, and turns of the camera, from what was recorded beside pictures.

The same as the target tracker's node does with what it hears.
"""

from __future__ import annotations

from cable_tracker.metric.odometry.motion import Unaided
from cable_tracker.metric.recorded.instrument_feed import InstrumentFeed
from cable_tracker.metric.recorded.recorded_cable import RecordedVehicle
from cable_tracker.metric.recorded.recorded_instruments import RecordedInstruments
from cable_tracker.metric.recorded.vehicle import VehicleDescription
from cable_tracker.metric.targets.target_metres import TargetMetres, TargetSettings
from cable_tracker.metric.targets.target_sight import TargetSight
from cable_tracker.node_parameter_tables import TargetVehicleParameters
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.estimate import TargetEstimate
from cable_tracker.tracking.parameter_table import ParameterValue, parameter_table

LONGEST_WAIT = 60.0
"""Longest wait for the instruments of a frame [s]; a replay has sent them before it."""


def target_parameters(
    vehicle: VehicleDescription, target_size: float = 0.0
) -> TargetVehicleParameters:
    """Return the parameters of a tracker of targets as a vehicle is described.

    A camera of which nothing is said looks straight ahead, not down.

    Parameters
    ----------
    vehicle : VehicleDescription
        Vehicle of the recording.
    target_size : float
        Root of the area that the target shows [m]; 0: not known.
    """
    own = {spec.name for spec in parameter_table(TargetVehicleParameters)}
    said = {name: getattr(vehicle.parameters, name) for name in vehicle.said & own}
    return TargetVehicleParameters(target_size=target_size).replaced(said)


def node_values(described: RecordedVehicle, target_size: float) -> dict[str, ParameterValue]:
    """Return the parameters with which the node takes the instruments of a replay as we do."""
    if not described.has_instruments:
        return {}
    found = set() if described.source is None else set(described.source.found.topics)
    waits = bool(found & {Instrument.IMU, Instrument.ODOMETRY})
    return target_parameters(described.vehicle, target_size).as_mapping() | {
        "instrument_reliability": "reliable",
        "instrument_wait": LONGEST_WAIT if waits else 0.0,
    }


class RecordedTargetSight(RecordedInstruments[TargetSight]):
    """Hands instruments of a recording to a `TargetSight`, in step with the frames.

    Parameters
    ----------
    described : RecordedVehicle
        The vehicle and its instruments.
    target_size : float
        Root of the area that the target shows [m]; 0: not known.

    Attributes
    ----------
    base_frame : str
        Frame of what is in metres.
    """

    def __init__(self, described: RecordedVehicle, target_size: float = 0.0) -> None:
        self._parameters = target_parameters(described.vehicle, target_size)
        self._calibration = described.vehicle.calibration
        self.base_frame = self._parameters.base_frame
        super().__init__(InstrumentFeed(described.source))

    def _first_sight(self) -> TargetSight:
        return TargetSight(self._parameters, self._calibration)

    @property
    def settings(self) -> TargetSettings:
        """Mounting and size."""
        return self._sight.settings

    @property
    def unaided(self) -> Unaided | None:
        """Why turns were not taken out of the last frame; None if they were."""
        return self._sight.unaided

    def camera_motion(self, stamp: int, image_size: tuple[int, int]) -> CameraMotion | None:
        """Return what turns of the vehicle did to the picture; see `TargetSight`."""
        return self._sight.camera_motion(stamp, image_size)

    def take(self, estimate: TargetEstimate) -> TargetMetres:
        """Return what a frame's estimate is in metres; once for each frame."""
        (metres,) = self._sight.take([estimate])
        return metres
