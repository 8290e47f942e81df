"""Base of what fuses the measurements of instruments with the estimates of a tracker.

The same for a node that hears instruments and for a recording that holds them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Generic, TypeVar

from cable_tracker.metric.calibration import Calibration
from cable_tracker.metric.messages import read_camera_info
from cable_tracker.node_parameter_tables import CableVehicleParameters, TargetVehicleParameters
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.messages.factory import Message

VehicleParameters = TypeVar(
    "VehicleParameters", bound=CableVehicleParameters | TargetVehicleParameters
)


class InstrumentFusion(ABC, Generic[VehicleParameters]):
    """Keeps the measurements of instruments so far, and the calibration in force.

    Parameters
    ----------
    parameters : CableVehicleParameters or TargetVehicleParameters
        How camera and instruments are mounted and read.
    calibration : Calibration or None
        Calibration given by the user, which overrides messages; None: that of the last
        `camera_info`.

    Attributes
    ----------
    parameters : CableVehicleParameters or TargetVehicleParameters
        The parameters in force.
    calibration : Calibration or None
        The calibration in force; None before any is known.
    """

    def __init__(self, parameters: VehicleParameters, calibration: Calibration | None) -> None:
        self.parameters = parameters
        self.calibration = calibration
        self._is_calibration_given = calibration is not None
        self._camera_info: Message | None = None

    @abstractmethod
    def forget_all(self) -> None:
        """Forget all measurements; the calibration stays."""

    @abstractmethod
    def _take_measurement(self, instrument: Instrument, stamp: int, message: Message) -> None:
        """Take a message of a time [ns]; one of an instrument that does not count is ignored."""

    def configure(self, parameters: VehicleParameters) -> None:
        """Take other parameters, and keep the measurements."""
        self.parameters = parameters
        self._read_camera_info()

    def take_message(self, instrument: Instrument, stamp: int, message: Message) -> None:
        """Take a message of a time [ns]; one of an instrument that does not count is ignored."""
        if instrument is Instrument.CAMERA_INFO:
            self._camera_info = message
            self._read_camera_info()
        else:
            self._take_measurement(instrument, stamp, message)

    def _read_camera_info(self) -> None:
        """Put the calibration of the last `camera_info` into force, unless the user gave one."""
        if self._camera_info is not None and not self._is_calibration_given:
            is_rectified = self.parameters.image_is_rectified
            self.calibration = read_camera_info(self._camera_info, is_rectified=is_rectified)


AnyFusion = TypeVar("AnyFusion", bound=InstrumentFusion[Any])
