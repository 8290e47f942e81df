"""The box that particles stay in."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import (
    DISTANCE,
    POSE_SIZE,
    POSE_WORDS,
    SKEW,
    WIDTH,
    pose_units,
)
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.tracking.parameter_table import pixel_scale

LEAST_EXTENT = np.array([0.0, 0.0, 0.8, math.radians(0.5)])
"""Smallest extent of `possible_limits`: d, alpha, w, beta [px at the reference width, rad]. Of what
is drawn about a cable, hardly anything would lie within narrower ones."""


class StateLimits(NamedTuple):
    """The box that particles stay in.

    Attributes
    ----------
    lower, upper : FloatArray
        Shape (4,): d, alpha, w, beta [px, rad]. The angle is not limited but wrapped.
    """

    lower: FloatArray
    upper: FloatArray


def state_limits(parameters: TrackerParameters, image_width: int) -> StateLimits:
    """Return the limits for frames of a given width [px]."""
    skew = np.deg2rad(parameters.skew_limit)
    distance = parameters.distance_limit
    units = pose_units(pixel_scale(image_width))
    return StateLimits(
        lower=units * [-distance, -np.inf, parameters.width_minimum, -skew],
        upper=units * [distance, np.inf, parameters.width_maximum, skew],
    )


def possible_limits(parameters: TrackerParameters, image_width: int) -> StateLimits:
    """Return the limits beyond which poses are impossible, for frames of a given width [px].

    Those of particles, but never so narrow that nothing which is drawn at random is possible.
    """
    lower, upper = state_limits(parameters, image_width)
    missing = np.maximum(LEAST_EXTENT * pose_units(pixel_scale(image_width)) - (upper - lower), 0.0)
    return StateLimits(lower - 0.5 * missing, upper + 0.5 * missing)


def describe_limit_violations(pose: FloatArray, limits: StateLimits) -> str:
    """Return which components of a pose (4,) lie beyond which parameters; empty if none does.

    A component that is NaN lies beyond nothing.
    """
    beyond = (
        (DISTANCE, "distance_limit", abs(pose[DISTANCE]) > limits.upper[DISTANCE]),
        (WIDTH, "width_minimum", pose[WIDTH] < limits.lower[WIDTH]),
        (WIDTH, "width_maximum", pose[WIDTH] > limits.upper[WIDTH]),
        (SKEW, "skew_limit", abs(pose[SKEW]) > limits.upper[SKEW]),
    )
    return ", ".join(
        f"{POSE_WORDS[column].format(pose[column])} by {name}"
        for column, name, is_beyond in beyond
        if is_beyond
    )


def clip_to_limits(states: FloatArray, limits: StateLimits) -> FloatArray:
    """Set components beyond a limit to the limit; shape (N, 8)."""
    result = states.copy()
    values = result[:, :POSE_SIZE]
    # `np.clip` does the same, in four times the time for few particles.
    np.minimum(np.maximum(values, limits.lower), limits.upper, out=values)
    return result
