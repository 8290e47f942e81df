"""Measurements of the vehicle's instruments, kept until an estimate asks for metres."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.estimate import CableEstimate
from cable_tracker.metric.altitude import Altitude
from cable_tracker.metric.calibration import Calibration, camera_for
from cable_tracker.metric.cross_track import CrossTrack, CrossTrackMeter
from cable_tracker.metric.frames import UNKNOWN_TILT, Attitude
from cable_tracker.metric.ground_view import GroundView
from cable_tracker.metric.history import History, Reading
from cable_tracker.metric.settings import altimeter_of, metric_settings
from cable_tracker.metric.withheld import Reason, Withheld
from cable_tracker.node_parameter_tables import CableVehicleParameters
from cable_tracker.stamps import NANOSECONDS

UNKNOWN_ATTITUDE = (
    f"an orientation_covariance of -1, or beyond {math.degrees(UNKNOWN_TILT):.0f} deg, says that"
    " none is known"
)
"""Such an attitude is not kept, and so what counts as missing may come all the time."""


class Instruments:
    """Keeps measurements, and turns estimates into metres with those of the same time.

    Parameters
    ----------
    parameters : CableVehicleParameters
        How camera and instruments are mounted and read.
    """

    def __init__(self, parameters: CableVehicleParameters) -> None:
        self.configure(parameters)
        self._calibration: Calibration | None = None
        self._altitudes = History()
        self._attitudes = History()

    def forget(self) -> None:
        """Forget all measurements; the calibration stays."""
        self._altitudes.clear()
        self._attitudes.clear()

    def configure(self, parameters: CableVehicleParameters) -> None:
        """Take other parameters, and keep the measurements."""
        self._parameters = parameters
        self._metric, self._altimeter = metric_settings(parameters), altimeter_of(parameters)

    def take_calibration(self, calibration: Calibration) -> None:
        """Use a calibration from now on."""
        self._calibration = calibration

    def take_altitude(self, stamp: int, metres: float, limits: tuple[float, float]) -> None:
        """Keep an altitude of a time [ns], with the altimeter's smallest and largest one [m]."""
        self._altitudes.add(stamp, np.array([metres, *limits]))

    def take_attitude(self, stamp: int, attitude: Attitude) -> None:
        """Keep an attitude of a time [ns]."""
        roll = _unwrapped(attitude.roll, self._attitudes.last_values)
        self._attitudes.add(stamp, np.array([roll, attitude.pitch, attitude.sigma]))

    def cross_track(self, estimate: CableEstimate) -> CrossTrack | Withheld:
        """Return the cable of an estimate in metres, or why not."""
        meter = CrossTrackMeter(self._metric, self._calibration)
        attitude = self.attitude_at(estimate.stamp)
        if isinstance(attitude, Withheld):
            # An altitude is read with an attitude: what withholds one withholds both. The meter
            # says first if no cable is claimed.
            return meter.measure(estimate, attitude, attitude)
        return meter.measure(estimate, self.altitude_at(estimate.stamp, attitude), attitude)

    def attitude_at(self, stamp: int) -> Attitude | Withheld:
        """Return the attitude at a time [ns]; level, with doubt, if there never was an imu."""
        if not len(self._attitudes):
            return Attitude(0.0, 0.0, math.radians(self._parameters.level_sigma))
        reading = self._attitudes.at(stamp)
        if reading is None or reading.nearest > self._parameters.instrument_timeout:
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
            fixed = self._parameters.fixed_altitude
            return Altitude(fixed, self._altimeter.relative_sigma * fixed)
        if not len(self._altitudes):
            return Withheld(
                Reason.NO_ALTITUDE, "none has come on altitude; or set the parameter fixed_altitude"
            )
        if reading is None or reading.nearest > self._parameters.instrument_timeout:
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
        if not self._parameters.fixed_altitude > 0.0:
            return False
        timeout = self._parameters.instrument_timeout
        if reading is None:
            begins = self._altitudes.between(stamp, stamp + round(timeout * NANOSECONDS))
            return bool(begins) or not len(self._altitudes)
        return reading.nearest > timeout

    def ground_view(self, estimate: CableEstimate) -> GroundView | Withheld:
        """Return the pose of the camera over the cable's plane in the frame of an estimate."""
        camera = camera_for(self._calibration, estimate.image_size)
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
            f"the last on {topic} is more than {self._parameters.instrument_timeout:g} s older than"
            " the image; look whether it still comes, and set all clocks alike"
        )


def _unwrapped(roll: float, before: FloatArray | None) -> float:
    """Return a roll [rad] within half a turn of the one before: it is interpolated as a number."""
    if before is None or not math.isfinite(before[0]) or not math.isfinite(roll):
        return roll
    return roll + math.tau * round((float(before[0]) - roll) / math.tau)
