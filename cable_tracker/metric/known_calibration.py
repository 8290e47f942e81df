"""The calibration that counts: one that the user gives, or that of the last `camera_info`."""

from __future__ import annotations

from cable_tracker.metric.calibration import Calibration
from cable_tracker.metric.messages import read_camera_info
from cable_tracker.sequences.messages.factory import Message


class KnownCalibration:
    """Keeps what is known of a camera's calibration.

    Parameters
    ----------
    given : Calibration or None
        Calibration given by the user, which overrides messages; None: use messages.
    is_rectified : bool
        Whether the images are rectified, as `read_camera_info` wants to know.
    """

    def __init__(self, given: Calibration | None, *, is_rectified: bool) -> None:
        self._given = given
        self._is_rectified = is_rectified
        self._camera_info: Message | None = None

    def configure(self, *, is_rectified: bool) -> None:
        """Read the last `camera_info` in another way."""
        self._is_rectified = is_rectified

    def take_camera_info(self, message: Message) -> None:
        """Keep a sensor_msgs/CameraInfo."""
        self._camera_info = message

    def read(self) -> Calibration | None:
        """Return the calibration; None before the first message if none is given."""
        if self._given is not None or self._camera_info is None:
            return self._given
        return read_camera_info(self._camera_info, is_rectified=self._is_rectified)
