"""From frame to frame: the vehicle's motion for the filter, and metres of the cable it has found.

The same for a node that hears instruments and for a recording that holds them.
"""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.movement import MotionAid
from cable_tracker.metric.calibration import Calibration
from cable_tracker.metric.cross_track import CrossTrack
from cable_tracker.metric.instruments import Instruments
from cable_tracker.metric.messages import read_attitude, read_range, read_twist
from cable_tracker.metric.odometry.aiding import MotionAiding
from cable_tracker.metric.odometry.motion import SWITCHED_OFF, Odometry, Unaided
from cable_tracker.metric.odometry.sea_bed_texture import TextureMotion
from cable_tracker.metric.sight import Sight
from cable_tracker.metric.withheld import Withheld
from cable_tracker.node_parameter_tables import CableVehicleParameters
from cable_tracker.sequences.bags.instruments import MOST_ALTITUDE, Instrument
from cable_tracker.sequences.messages.factory import Message

CABLE_INSTRUMENTS = (
    Instrument.CAMERA_INFO, Instrument.ALTITUDE, Instrument.IMU, Instrument.ODOMETRY,
)  # fmt: skip
"""Instruments whose messages count."""


class CableSight(Sight[CableVehicleParameters]):
    """Keeps what is known of camera, vehicle and sea bed.

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
    unaided : Unaided or None
        Why the filter was not told of the motion to the last frame; None if it was.
    """

    def __init__(
        self,
        parameters: CableVehicleParameters,
        calibration: Calibration | None = None,
        texture_pause: float = 0.0,
    ) -> None:
        self._texture_pause = texture_pause
        self._instruments = Instruments(parameters)
        self._forget_motion()
        super().__init__(parameters, calibration)

    def configure(self, parameters: CableVehicleParameters) -> None:
        """Take other parameters, and keep the measurements."""
        self._instruments.configure(parameters)
        super().configure(parameters)

    def forget_all(self) -> None:
        """Forget all measurements; the calibration stays."""
        self._instruments.forget()
        self._forget_motion()

    def _forget_motion(self) -> None:
        self._odometry = Odometry()
        self._aiding = MotionAiding(self._instruments, self._odometry, self._texture_pause)
        self.unaided: Unaided | None = None

    def _take_calibration(self, calibration: Calibration) -> None:
        self._instruments.take_calibration(calibration)

    def _take_measurement(self, instrument: Instrument, stamp: int, message: Message) -> None:
        if instrument is Instrument.ALTITUDE:
            self._instruments.take_altitude(stamp, *_read_altitude(message))
        elif instrument is Instrument.IMU:
            least = math.radians(self._parameters.imu_sigma)
            attitude = read_attitude(message, least)
            if attitude is not None:
                self._instruments.take_attitude(stamp, attitude)
        elif instrument is Instrument.ODOMETRY:
            least_sigmas = (
                self._parameters.velocity_sigma,
                math.radians(self._parameters.turn_sigma),
            )
            self._odometry.add(stamp, *read_twist(message, least_sigmas))

    @property
    def instruments(self) -> Instruments:
        """Calibration, altitude, attitude as they are known so far."""
        return self._instruments

    @property
    def texture_motion(self) -> TextureMotion | None:
        """How the sea bed moved up to the last frame, beside the prediction; None: not known."""
        return self._aiding.texture_motion

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
        if not self._parameters.motion_aid:
            self.unaided = SWITCHED_OFF
            self._aiding.forget_picture()
            return None
        motion = self._aiding.motion(stamp, image)
        self.unaided = self._aiding.unaided
        return motion

    def observe(self, estimate: CableEstimate) -> None:
        """Learn from an estimate how far odometry may be believed; once for each frame."""
        self._aiding.observe(estimate)

    def measure(self, estimate: CableEstimate) -> CrossTrack | Withheld:
        """Return the cable of an estimate in metres, or why not."""
        return self._instruments.cross_track(estimate)


def _read_altitude(message: Message) -> tuple[float, tuple[float, float]]:
    """Read a sensor_msgs/Range or a plain number: the distance and its limits [m]."""
    if hasattr(message, "range"):
        return read_range(message)
    # In single precision, as a Range would hold it: a replay sends numbers as such.
    return float(np.float32(message.data)), (0.0, MOST_ALTITUDE)
