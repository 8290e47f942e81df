"""Fusion of a vehicle's instruments with the tracker of a cable: motion aid in, metres out."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.cable.model.movement import MotionAid
from cable_tracker.metric.altitude import Altimeter, Altitude
from cable_tracker.metric.calibration import Calibration, camera_for
from cable_tracker.metric.cross_track import CrossTrack, CrossTrackMeter, MetricSettings
from cable_tracker.metric.frames import UNKNOWN_TILT, Attitude, mounting_of
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.metric.history import History, Reading
from cable_tracker.metric.instrument_fusion import InstrumentFusion
from cable_tracker.metric.messages import read_attitude, read_range, read_twist
from cable_tracker.metric.odometry.aiding import MotionAiding
from cable_tracker.metric.odometry.motion import SWITCHED_OFF, Odometry
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.node_parameter_tables import CableVehicleParameters
from cable_tracker.sequences.bags.instruments import MOST_ALTITUDE, Instrument
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.stamps import NANOSECONDS

CABLE_INSTRUMENTS = (
    Instrument.CAMERA_INFO, Instrument.ALTITUDE, Instrument.IMU, Instrument.ODOMETRY,
)  # fmt: skip
"""Instruments whose messages count."""

UNKNOWN_ATTITUDE = (
    f"an orientation_covariance of -1, or beyond {math.degrees(UNKNOWN_TILT):.0f} deg, says that"
    " none is known"
)
"""Such an attitude is not kept, and so what counts as missing may come all the time."""


class CableInstrumentFusion(InstrumentFusion[CableVehicleParameters]):
    """Tells the filter how the vehicle moves, and converts its estimates to metres.

    Altitude and attitude are kept, and count at the time of the estimate.

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
    aiding : MotionAiding
        Prediction of the motion, and why the last frame was not aided.
    """

    def __init__(
        self,
        parameters: CableVehicleParameters,
        calibration: Calibration | None = None,
        texture_pause: float = 0.0,
    ) -> None:
        super().__init__(parameters, calibration)
        self._texture_pause = texture_pause
        self._metric, self._altimeter = metric_settings(parameters), altimeter_of(parameters)
        self.forget_all()

    def configure(self, parameters: CableVehicleParameters) -> None:
        """Take other parameters, and keep the measurements."""
        self._metric, self._altimeter = metric_settings(parameters), altimeter_of(parameters)
        super().configure(parameters)

    def forget_all(self) -> None:
        """Forget all measurements; the calibration stays."""
        self._altitudes, self._attitudes = History(), History()
        self._odometry = Odometry()
        self.aiding = MotionAiding(self.ground_view, self._odometry, self._texture_pause)

    def _take_measurement(self, instrument: Instrument, stamp: int, message: Message) -> None:
        if instrument is Instrument.ALTITUDE:
            self.take_altitude(stamp, *_read_altitude(message))
        elif instrument is Instrument.IMU:
            least = math.radians(self.parameters.imu_sigma)
            attitude = read_attitude(message, least)
            if attitude is not None:
                self.take_attitude(stamp, attitude)
        elif instrument is Instrument.ODOMETRY:
            least_sigmas = (
                self.parameters.velocity_sigma,
                math.radians(self.parameters.turn_sigma),
            )
            self._odometry.add(stamp, *read_twist(message, least_sigmas))

    def take_altitude(self, stamp: int, metres: float, limits: tuple[float, float]) -> None:
        """Keep an altitude of a time [ns], with the altimeter's smallest and largest one [m]."""
        self._altitudes.add(stamp, np.array([metres, *limits]))

    def take_attitude(self, stamp: int, attitude: Attitude) -> None:
        """Keep an attitude of a time [ns]."""
        roll = _unwrapped(attitude.roll, self._attitudes.last_values)
        self._attitudes.add(stamp, np.array([roll, attitude.pitch, attitude.sigma]))

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
        meter = CrossTrackMeter(self._metric, self.calibration)
        attitude = self.attitude_at(estimate.stamp)
        if isinstance(attitude, Withheld):
            # An altitude is read with an attitude: what withholds one withholds both. The meter
            # says first if no cable is claimed.
            return meter.measure(estimate, attitude, attitude)
        return meter.measure(estimate, self.altitude_at(estimate.stamp, attitude), attitude)

    def attitude_at(self, stamp: int) -> Attitude | Withheld:
        """Return the attitude at a time [ns]; level, with doubt, if there never was an imu."""
        if not len(self._attitudes):
            return Attitude(0.0, 0.0, math.radians(self.parameters.level_sigma))
        reading = self._attitudes.at(stamp)
        if reading is None or reading.nearest > self.parameters.instrument_timeout:
            why = self._stale("imu", is_later=reading is None)
            return Withheld(Reason.STALE_ATTITUDE, f"{why}; {UNKNOWN_ATTITUDE}")
        attitude = Attitude(*(float(value) for value in reading.values))
        if not attitude.is_finite():
            return Withheld(Reason.BAD_ATTITUDE, "roll or pitch is not finite; look at the imu")
        return replace(attitude, roll=math.remainder(attitude.roll, math.tau))

    def altitude_at(self, stamp: int, attitude: Attitude) -> Altitude | Withheld:
        """Return the altitude of base_link at a time [ns]."""
        reading = self._altitudes.at(stamp)
        if self._is_fixed(stamp, reading):
            fixed = self.parameters.fixed_altitude
            return Altitude(fixed, self._altimeter.relative_sigma * fixed)
        if not len(self._altitudes):
            return Withheld(
                Reason.NO_ALTITUDE, "none has come on altitude; or set the parameter fixed_altitude"
            )
        if reading is None or reading.nearest > self.parameters.instrument_timeout:
            return Withheld(
                Reason.STALE_ALTITUDE, self._stale("altitude", is_later=reading is None)
            )
        # An altitude that cannot be must not be bridged by its neighbours.
        for values in (*self._altitudes.around(stamp), reading.values):
            metres, low, high = (float(value) for value in values)
            altitude = self._altimeter.read(metres, attitude, (low, high))
            if isinstance(altitude, Withheld):
                return altitude
        return altitude

    def stand_in_at(self, stamp: int) -> str:
        """Return why `fixed_altitude` stands in for an altimeter at a time [ns]; else empty.

        Metres go on then, with an altitude that may be another one than the last that was measured.
        """
        reading = self._altitudes.at(stamp)
        if reading is None or not self._is_fixed(stamp, reading):
            return ""
        return f"fixed_altitude stands in: {self._stale('altitude', is_later=False)}"

    def _is_fixed(self, stamp: int, reading: Reading | None) -> bool:
        """Tell whether `fixed_altitude` counts: where no altitude comes yet, or none any more.

        An altimeter whose stamps are all later than the image has just begun to speak, or its clock
        is wrong where they are later by more than the timeout.
        """
        if not self.parameters.fixed_altitude > 0.0:
            return False
        timeout = self.parameters.instrument_timeout
        if reading is None:
            begins = self._altitudes.between(stamp, stamp + round(timeout * NANOSECONDS))
            return bool(begins) or not len(self._altitudes)
        return reading.nearest > timeout

    def ground_view(self, estimate: CableEstimate) -> GroundView | Withheld:
        """Return the pose of the camera over the cable's plane in the frame of an estimate."""
        camera = camera_for(self.calibration, estimate.image_size)
        if isinstance(camera, Withheld):
            return camera
        attitude = self.attitude_at(estimate.stamp)
        if isinstance(attitude, Withheld):
            return attitude
        altitude = self.altitude_at(estimate.stamp, attitude)
        if isinstance(altitude, Withheld):
            return altitude
        height = altitude.metres - self._metric.cable_height
        return GroundView(camera, self._metric.mounting, attitude, height, altitude.sigma)

    def _stale(self, topic: str, *, is_later: bool) -> str:
        if is_later:
            return f"{topic} has only later stamps than the image; set all clocks alike"
        return (
            f"the last on {topic} is more than {self.parameters.instrument_timeout:g} s older than"
            " the image; look whether it still comes, and set all clocks alike"
        )


def _read_altitude(message: Message) -> tuple[float, tuple[float, float]]:
    """Read a sensor_msgs/Range or a plain number: the distance and its limits [m]."""
    if hasattr(message, "range"):
        return read_range(message)
    # In single precision, as a Range would hold it: a replay sends numbers as such.
    return float(np.float32(message.data)), (0.0, MOST_ALTITUDE)


def _unwrapped(roll: float, before: FloatArray | None) -> float:
    """Return a roll [rad] within half a turn of the one before: it is interpolated as a number."""
    if before is None or not math.isfinite(before[0]) or not math.isfinite(roll):
        return roll
    return roll + math.tau * round((float(before[0]) - roll) / math.tau)


def metric_settings(parameters: CableVehicleParameters) -> MetricSettings:
    """Return the settings of a `CrossTrackMeter`."""
    return MetricSettings(mounting_of(parameters), parameters.look_ahead, parameters.cable_height)


def altimeter_of(parameters: CableVehicleParameters) -> Altimeter:
    """Return the altimeter that the parameters describe."""
    return Altimeter(
        (parameters.altimeter_x, parameters.altimeter_y, parameters.altimeter_z),
        parameters.altitude_is_vertical,
        parameters.altitude_sigma,
    )
