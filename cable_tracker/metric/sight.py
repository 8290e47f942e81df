"""What every sight can do: a node's inputs and a recording hand instruments to it."""

from __future__ import annotations

from typing import Any, Protocol, TypeVar

from cable_tracker.node_parameter_tables import CableVehicleParameters, TargetVehicleParameters
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.messages.factory import Message

VehicleParameters_contra = TypeVar(
    "VehicleParameters_contra",
    bound=CableVehicleParameters | TargetVehicleParameters,
    contravariant=True,
)


class Sight(Protocol[VehicleParameters_contra]):
    """Keeps what instruments have said so far: `CableSight` or `TargetSight`."""

    def configure(self, parameters: VehicleParameters_contra) -> None:
        """Take other parameters, and keep the measurements."""

    def forget_all(self) -> None:
        """Forget all measurements; the calibration stays."""

    def take_message(self, instrument: Instrument, stamp: int, message: Message) -> None:
        """Take a message of a time [ns]; one of an instrument that does not count is ignored."""


AnySight = TypeVar("AnySight", bound=Sight[Any])
