"""From the parameters of `METRIC_PARAMETERS` to settings, and from a bag's frames to parameters."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import cast

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.metric.altitude import Altimeter
from cable_tracker.metric.cross_track import MetricSettings
from cable_tracker.metric.frames import OPTICAL_IN_BODY, Mounting
from cable_tracker.metric.instruments import InstrumentSettings
from cable_tracker.metric.targets.target_metres import TargetSettings
from cable_tracker.node_parameter_tables import METRIC_PARAMETERS, MOUNTING_PARAMETERS
from cable_tracker.tracking.parameter_table import ParameterSpec


def default_values(specs: Iterable[ParameterSpec] = METRIC_PARAMETERS) -> dict[str, object]:
    """Return the values of parameters, by name, as they are without anything else being said."""
    return {spec.name: spec.default for spec in specs}


def number(values: Mapping[str, object], name: str) -> float:
    """Return a parameter that is a number."""
    return float(cast(float, values[name]))


def mounting_of(values: Mapping[str, object]) -> Mounting:
    """Return the mounting that the parameters `camera_*` describe."""
    return Mounting(
        number(values, "camera_x"),
        number(values, "camera_y"),
        number(values, "camera_z"),
        math.radians(number(values, "camera_roll")),
        math.radians(number(values, "camera_pitch")),
        math.radians(number(values, "camera_yaw")),
    )


def instrument_settings(values: Mapping[str, object]) -> InstrumentSettings:
    """Return how instruments are to be read, of all of `METRIC_PARAMETERS` by name."""
    return InstrumentSettings(
        metric=MetricSettings(
            mounting_of(values), number(values, "look_ahead"), number(values, "cable_height")
        ),
        altimeter=Altimeter(
            (
                number(values, "altimeter_x"),
                number(values, "altimeter_y"),
                number(values, "altimeter_z"),
            ),
            bool(values["altitude_is_vertical"]),
            number(values, "altitude_sigma"),
        ),
        fixed_altitude=number(values, "fixed_altitude"),
        timeout=number(values, "instrument_timeout"),
        level_sigma=math.radians(number(values, "level_sigma")),
    )


def target_settings(values: Mapping[str, object]) -> TargetSettings:
    """Return how targets are to be measured, of all of `TARGET_METRIC_PARAMETERS` by name."""
    return TargetSettings(
        mounting_of(values), number(values, "target_size"), bool(values["motion_aid"])
    )


def camera_parameters(rotation: FloatArray, place: FloatArray) -> dict[str, object]:
    """Return the parameters `camera_*` for a camera's optical frame in base_link.

    Parameters
    ----------
    rotation : FloatArray
        From the optical frame to base_link, shape (3, 3).
    place : FloatArray
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
    values = (float(value) for value in (*place, *angles))
    return dict(zip(MOUNTING_PARAMETERS, values, strict=True))
