"""From frame to frame: turns of the camera for the filter, and metres of what it has found.

The same for a node that hears instruments and for a recording that holds them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from cable_tracker.metric.calibration import CameraModel
from cable_tracker.metric.messages import read_camera_info, read_rates_of_turn, read_twist
from cable_tracker.metric.motion import NoMotion, PoseChange
from cable_tracker.metric.target_metres import (
    TargetMetres,
    TargetRange,
    TargetSettings,
    VehicleMotion,
    turn_of_picture,
)
from cable_tracker.sequences.messages.factory import Message
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.estimate import TargetEstimate

LEAST_SIGMAS = (0.02, math.radians(0.3))
"""Doubt about velocities and turns that odometry does not state [m/s, rad/s]."""

FIRST_FRAME = NoMotion("no frame has come before")


class TargetSight:
    """Keeps what is known of camera, vehicle and the ranges of targets.

    Parameters
    ----------
    settings : TargetSettings
        See there.
    count : int
        How many targets are followed.
    """

    def __init__(self, settings: TargetSettings, count: int = 1) -> None:
        self._settings = settings
        self._motion = VehicleMotion()
        self._ranges = [TargetRange(settings) for _ in range(count)]
        self._before: int | None = None
        self._moved: tuple[PoseChange, bool] | NoMotion = FIRST_FRAME
        self._why_unaided = ""

    @property
    def settings(self) -> TargetSettings:
        """Those in force."""
        return self._settings

    @property
    def why_unaided(self) -> str:
        """Why turns were not taken out of the last frame; empty if they were."""
        return self._why_unaided

    def configure(self, settings: TargetSettings) -> None:
        """Take other settings."""
        self._settings = settings
        for each in self._ranges:
            each.configure(settings)

    def forget(self, number: int | None = None) -> None:
        """Begin anew with the range of one target, or of all."""
        for each in self._ranges if number is None else [self._ranges[number]]:
            each.forget()

    def take_camera_info(self, message: Message, *, is_rectified: bool) -> None:
        """Take a calibration."""
        self._motion.take_calibration(read_camera_info(message, is_rectified=is_rectified))

    def take_imu(self, stamp: int, message: Message) -> None:
        """Take rates of turn of a time [ns], if the message has some."""
        rates = read_rates_of_turn(message)
        if rates is not None:
            self._motion.take_turn(stamp, rates)

    def take_odometry(self, stamp: int, message: Message) -> None:
        """Take a twist of base_link of a time [ns]."""
        self._motion.take_twist(stamp, *read_twist(message, LEAST_SIGMAS))

    @property
    def motion(self) -> VehicleMotion:
        """Calibration and motion, as far as they are known."""
        return self._motion

    def camera_motion(self, stamp: int, image_size: tuple[int, int]) -> CameraMotion | None:
        """Return what turns of the vehicle did to the picture since the frame before.

        None where they are not known. Call it for each frame, before the filter looks at it.

        Parameters
        ----------
        stamp : int
            Time of the frame [ns].
        image_size : (int, int)
            Width and height [px].
        """
        self._moved = (
            FIRST_FRAME if self._before is None else self._motion.between(self._before, stamp)
        )
        camera = self._motion.camera(image_size)
        if not self._settings.uses_motion:
            self._why_unaided = "the parameter motion_aid is false"
        elif isinstance(self._moved, NoMotion):
            self._why_unaided = self._moved.why
        elif not isinstance(camera, CameraModel):
            self._why_unaided = str(camera)
        else:
            self._why_unaided = ""
            return turn_of_picture(camera, self._settings.mounting, self._moved[0].rotation)
        return None

    def take(self, estimates: Sequence[TargetEstimate]) -> list[TargetMetres]:
        """Return what a frame's estimates are in metres; once for each frame."""
        self._before = estimates[0].stamp
        return [
            each.take(estimate, self._motion.camera(estimate.image_size), self._moved)
            for each, estimate in zip(self._ranges, estimates, strict=True)
        ]
