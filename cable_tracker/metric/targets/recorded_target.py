"""Bearing and range of a target, and the camera's rotation, from the recorded instruments.

The same as the target tracker's node does with what it hears.
"""

from __future__ import annotations

from cable_tracker.metric.recorded_instruments import (
    InstrumentFeed,
    RecordedInstruments,
    RecordedVehicle,
)
from cable_tracker.metric.targets.target_instrument_fusion import TargetInstrumentFusion
from cable_tracker.metric.vehicle_description import VehicleDescription
from cable_tracker.node_parameter_tables import TargetVehicleParameters
from cable_tracker.sequences.bags.instruments import Instrument
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


def recorded_target(
    described: RecordedVehicle, target_size: float = 0.0
) -> RecordedInstruments[TargetInstrumentFusion]:
    """Return the instruments of a recording, fused in step with its frames.

    Parameters
    ----------
    described : RecordedVehicle
        The vehicle and its instruments.
    target_size : float
        Root of the area that the target shows [m]; 0: not known.
    """
    parameters = target_parameters(described.vehicle, target_size)
    return RecordedInstruments(
        InstrumentFeed(described.source),
        lambda: TargetInstrumentFusion(parameters, described.vehicle.calibration),
    )
