"""From the vehicle's parameters to mountings, and from a bag's frames to parameters."""

from __future__ import annotations

import math

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.altitude import Altimeter
from cable_tracker.metric.cross_track import MetricSettings
from cable_tracker.metric.frames import OPTICAL_IN_BODY, Mounting
from cable_tracker.node_parameter_tables import (
    MOUNTING_PARAMETERS,
    CableVehicleParameters,
    TargetVehicleParameters,
)


def mounting_of(parameters: CableVehicleParameters | TargetVehicleParameters) -> Mounting:
    """Return the mounting that the parameters `camera_*` describe."""
    return Mounting(
        parameters.camera_x,
        parameters.camera_y,
        parameters.camera_z,
        math.radians(parameters.camera_roll),
        math.radians(parameters.camera_pitch),
        math.radians(parameters.camera_yaw),
    )


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


def camera_parameters(rotation: FloatArray, position: FloatArray) -> dict[str, object]:
    """Return the parameters `camera_*` for a camera's optical frame in base_link.

    Parameters
    ----------
    rotation : FloatArray
        From the optical frame to base_link, shape (3, 3).
    position : FloatArray
        Position of the camera in base_link, shape (3,) [m].
    """
    body = rotation @ OPTICAL_IN_BODY.T
    pitch = math.asin(max(-1.0, min(1.0, -float(body[2, 0]))))
    if abs(body[2, 0]) > 1.0 - 1e-9:
        # Straight down or up: only the sum or difference of roll and yaw is known; all is yaw.
        roll, yaw = 0.0, math.atan2(-float(body[0, 1]), float(body[1, 1]))
    else:
        roll = math.atan2(float(body[2, 1]), float(body[2, 2]))
        yaw = math.atan2(float(body[1, 0]), float(body[0, 0]))
    angles = np.degrees([roll, pitch, yaw])
    values = (float(value) for value in (*position, *angles))
    return dict(zip(MOUNTING_PARAMETERS, values, strict=True))
