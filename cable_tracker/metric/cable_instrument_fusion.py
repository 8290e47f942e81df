"""Fusion of a vehicle's instruments with the tracker of a cable: motion aid in, metres out."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.movement import MotionAid
from cable_tracker.metric.calibration import Calibration
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.instrument_fusion import InstrumentFusion
from cable_tracker.metric.instruments import Instruments
from cable_tracker.metric.messages import read_attitude, read_range, read_twist
from cable_tracker.metric.odometry.aiding import MotionAiding
from cable_tracker.metric.odometry.motion import SWITCHED_OFF, Odometry
from cable_tracker.metric.withheld import Withheld
from cable_tracker.node_parameter_tables import CableVehicleParameters
from cable_tracker.sequences.bags.instruments import MOST_ALTITUDE, Instrument
from cable_tracker.sequences.messages.factory import Message

CABLE_INSTRUMENTS = (
    Instrument.CAMERA_INFO, Instrument.ALTITUDE, Instrument.IMU, Instrument.ODOMETRY,
)  # fmt: skip
"""Instruments whose messages count."""


class CableInstrumentFusion(InstrumentFusion[CableVehicleParameters]):
    """Tells the filter how the vehicle moves, and converts its estimates to metres.

    Parameters
    ----------
    parameters : CableVehicleParameters
        How camera and instruments are mounted and read.
    calibration : Calibration or None
        Calibration given by the user, which overrides messages; None: use messages.
    texture_pause : float
        Least time between two comparisons of texture, see `MotionAiding` [s].

    Attributes
    ----------
    instruments : Instruments
        Calibration, altitude, attitude as they are known so far.
    aiding : MotionAiding
        Prediction of the motion, and why the last frame was not aided.
    """

    def __init__(
        self,
        parameters: CableVehicleParameters,
        calibration: Calibration | None = None,
        texture_pause: float = 0.0,
    ) -> None:
        self._texture_pause = texture_pause
        self.instruments = Instruments(parameters)
        self._forget_motion()
        super().__init__(parameters, calibration)

    def configure(self, parameters: CableVehicleParameters) -> None:
        """Take other parameters, and keep the measurements."""
        self.instruments.configure(parameters)
        super().configure(parameters)

    def forget_all(self) -> None:
        """Forget all measurements; the calibration stays."""
        self.instruments.forget()
        self._forget_motion()

    def _forget_motion(self) -> None:
        self._odometry = Odometry()
        self.aiding = MotionAiding(self.instruments, self._odometry, self._texture_pause)

    def _take_calibration(self, calibration: Calibration) -> None:
        self.instruments.take_calibration(calibration)

    def _take_measurement(self, instrument: Instrument, stamp: int, message: Message) -> None:
        if instrument is Instrument.ALTITUDE:
            self.instruments.take_altitude(stamp, *_read_altitude(message))
        elif instrument is Instrument.IMU:
            least = math.radians(self.parameters.imu_sigma)
            attitude = read_attitude(message, least)
            if attitude is not None:
                self.instruments.take_attitude(stamp, attitude)
        elif instrument is Instrument.ODOMETRY:
            least_sigmas = (
                self.parameters.velocity_sigma,
                math.radians(self.parameters.turn_sigma),
            )
            self._odometry.add(stamp, *read_twist(message, least_sigmas))

    def motion(self, stamp: int, image: Image) -> MotionAid | None:
        """Return how the cable has moved since the frame before.

        None without odometry, or while it disagrees with what the camera sees. Call it for each
        frame, before the filter looks at it.

        Parameters
        ----------
        stamp : int
            Time of the frame [ns].
        image : Image
            The frame: grey levels, uint8 or float32 (0..255), shape (H, W).
        """
        if not self.parameters.motion_aid:
            self.aiding.pause(SWITCHED_OFF)
            return None
        return self.aiding.motion(stamp, image)

    def observe(self, estimate: CableEstimate) -> None:
        """Learn from an estimate how far odometry may be believed; once for each frame."""
        self.aiding.observe(estimate)

    def measure(self, estimate: CableEstimate) -> CrossTrack | Withheld:
        """Return the cable of an estimate in metres, or why not."""
        return self.instruments.cross_track(estimate)


def _read_altitude(message: Message) -> tuple[float, tuple[float, float]]:
    """Read a sensor_msgs/Range or a plain number: the distance and its limits [m]."""
    if hasattr(message, "range"):
        return read_range(message)
    # In single precision, as a Range would hold it: a replay sends numbers as such.
    return float(np.float32(message.data)), (0.0, MOST_ALTITUDE)
