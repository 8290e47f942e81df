"""Fusion of a vehicle's instruments with the tracker of targets: rotation in, metres out."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cable_tracker.metric.calibration import Calibration, CameraModel, camera_for
from cable_tracker.metric.frames import mounting_of
from cable_tracker.metric.instrument_fusion import InstrumentFusion
from cable_tracker.metric.messages import read_rates_of_turn, read_twist
from cable_tracker.metric.odometry.motion import (
    FIRST_FRAME,
    SWITCHED_OFF,
    Odometry,
    PoseChange,
    Unaided,
    moved_between,
)
from cable_tracker.metric.targets.target_metres import TargetMetres, TargetRange, turn_of_picture
from cable_tracker.node_parameter_tables import TargetVehicleParameters
from cable_tracker.sequences.bags.instruments import Instrument
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.estimate import TargetEstimate

TARGET_INSTRUMENTS = (Instrument.CAMERA_INFO, Instrument.IMU, Instrument.ODOMETRY)
"""Instruments whose messages count."""

LEAST_SIGMAS = (0.02, math.radians(0.3))
"""Doubt about velocities and turns that odometry does not state [m/s, rad/s]."""

TURNED_TOO_FAR = Unaided("the camera is said to have turned away from what the frame before showed")


class TargetInstrumentFusion(InstrumentFusion[TargetVehicleParameters]):
    """Tells the filter how the camera turns, and converts its estimates to metres.

    Parameters
    ----------
    parameters : TargetVehicleParameters
        How the camera is mounted and read, and how large the target is.
    calibration : Calibration or None
        Calibration given by the user, which overrides messages; None: use messages.
    count : int
        Number of targets.

    Attributes
    ----------
    unaided : Unaided or None
        Why turns were not taken out of the last frame; None if they were.
    """

    def __init__(
        self,
        parameters: TargetVehicleParameters,
        calibration: Calibration | None = None,
        count: int = 1,
    ) -> None:
        super().__init__(parameters, calibration)
        self._ranges = [TargetRange(parameters) for _ in range(count)]
        self._forget_motion()

    def _forget_motion(self) -> None:
        self._odometry, self._gyroscope = Odometry(), Odometry("imu")
        self._before: int | None = None
        self._moved: PoseChange | Unaided = FIRST_FRAME
        self.unaided: Unaided | None = None

    def configure(self, parameters: TargetVehicleParameters) -> None:
        """Take other parameters, and keep the measurements."""
        for each in self._ranges:
            each.configure(parameters)
        super().configure(parameters)

    def forget(self, number: int | None = None) -> None:
        """Begin anew with the range of one target, or of all."""
        for each in self._ranges if number is None else [self._ranges[number]]:
            each.forget()

    def forget_all(self) -> None:
        """Forget ranges, measurements and the last frame; the calibration stays."""
        self.forget()
        self._forget_motion()

    def _take_measurement(self, instrument: Instrument, stamp: int, message: Message) -> None:
        if instrument is Instrument.IMU:
            rates = read_rates_of_turn(message)
            if rates is not None:
                self._gyroscope.add_turn(stamp, rates)
        elif instrument is Instrument.ODOMETRY:
            self._odometry.add(stamp, *read_twist(message, LEAST_SIGMAS))

    def camera_motion(self, stamp: int, image_size: tuple[int, int]) -> CameraMotion | None:
        """Return the image motion by turns of the vehicle since the frame before.

        None where they are not known. Call it for each frame, before the filter looks at it.

        Parameters
        ----------
        stamp : int
            Time of the frame [ns].
        image_size : (int, int)
            Width and height [px].
        """
        self._moved = (
            FIRST_FRAME
            if self._before is None
            else moved_between(self._odometry, self._gyroscope, self._before, stamp)
        )
        camera = camera_for(self.calibration, image_size)
        if not self.parameters.motion_aid:
            self.unaided = SWITCHED_OFF
        elif isinstance(self._moved, Unaided):
            self.unaided = self._moved
        elif not isinstance(camera, CameraModel):
            self.unaided = Unaided(str(camera))
        else:
            turn = turn_of_picture(camera, mounting_of(self.parameters), self._moved.rotation)
            self.unaided = TURNED_TOO_FAR if turn is None else None
            return turn
        return None

    def take(self, estimates: Sequence[TargetEstimate]) -> list[TargetMetres]:
        """Convert the estimates of a frame to metres; call it once for each frame."""
        self._before = estimates[0].stamp
        return [
            each.take(estimate, camera_for(self.calibration, estimate.image_size), self._moved)
            for each, estimate in zip(self._ranges, estimates, strict=True)
        ]
