"""Motion of a cable through the image in a world: as in inspections by ROV, or lively."""

from __future__ import annotations

from enum import Enum

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.cable.model.state import ANGLE, DISTANCE, POSE_SIZE, SKEW, STATE_SIZE, WIDTH
from cable_tracker.simulation.trajectory import Bands, Harmonics
from cable_tracker.tracking.parameter_table import REFERENCE_WIDTH

WORLD_RATE = 25.0
"""Frames per second of all worlds."""

INSPECTION_STEPS = (0.195, float(np.deg2rad(0.053)), 0.145, float(np.deg2rad(0.036)))
"""Scale of the steps of d, alpha, w, beta from frame to frame [px at 320 px, rad]."""

INSPECTION_TAILS = (0.76, 0.87, 0.81, 1.1)
"""Standard deviation of the logarithm of that scale in the course of time: how heavy the tails."""

STEP_MEMORY = 0.8
"""Correlation time of the direction of a movement [s]."""

SCALE_MEMORY = 3.0
"""Correlation time of the scale of the steps [s]."""

RETURN_TIME = 8.0
"""Time constant with which the vehicle steers back to the mean pose [s]."""

PIPE_WIDTH = (112.0, 41.0)
"""Mean and standard deviation of the width of an inspected pipe [px at 320 px]."""

PIPE_WIDTHS = (28.0, 205.0)
"""Smallest and largest width of an inspected pipe [px at 320 px]."""

PIPE_SKEW = (15.6, 2.8)
"""Mean and standard deviation of the angle between its borders and its axis at that width [deg]."""

SKEW_OF_WIDTH = 0.04
"""Increase of the angle between borders and axis for each pixel of a pipe's width [deg]."""

PIPE_SKEWS = (4.0, 24.5)
"""Smallest and largest angle between a pipe's borders and its axis [deg]."""

NEAREST_APEX = 130.0
"""Least distance from the foot point to where both borders meet, the horizon [px]."""

USUAL_HEIGHT = 240.0
"""Largest height of pictures for which `NEAREST_APEX` suffices [px at 320 px]."""

APEX_MARGIN = 10.0
"""Least distance of that point outside higher pictures [px at 320 px]."""

LIVELY_BANDS: Bands = ((0.25, 0.4), (0.5, 0.7), (0.9, 1.2))
"""Frequencies of the lively motion [Hz]."""

LIVELY_LIMITS = (55.0, float(np.deg2rad(16.0)), 0.3, float(np.deg2rad(2.0)))
"""Largest swing of d [px], alpha [rad], w (share of the mean) and beta [rad] when lively."""


class MotionKind(str, Enum):
    """Kind of the cable's motion through the image."""

    INSPECTION = "inspection"
    """Calm, with sudden moves: steps have the spread and the tails of real inspections by ROV."""

    LIVELY = "lively"
    """Swinging, as the small vehicle of the thesis moved."""


def random_motion(
    kind: MotionKind,
    widths: tuple[float, float] | None,
    angles: tuple[float, float],
    frame_count: int,
    rng: np.random.Generator,
    *,
    height: float = USUAL_HEIGHT,
) -> FloatArray:
    """Draw the motion of a cable.

    Parameters
    ----------
    widths : (float, float) or None
        Narrowest and widest mean width, drawn uniformly in its logarithm [px at 320 px]; None: as
        pipes show in real inspections, whatever the angles.
    angles : (float, float)
        Smallest and largest mean angle [deg].
    frame_count : int
        Number of frames at `WORLD_RATE`.
    height : float
        Height of the pictures [px at 320 px].

    Returns
    -------
    FloatArray
        d, alpha, w, beta and their rates in each frame, shape (N, 8) [px at 320 px, rad, per
        second].
    """
    means = _random_means(widths, angles, rng)
    if kind is MotionKind.INSPECTION:
        poses = _inspection_motion(means, frame_count, rng)
    else:
        poses = _lively_motion(means, frame_count, rng)
    states = np.zeros((frame_count, STATE_SIZE))
    width = np.maximum(poses[:, WIDTH], 3.0)
    steepest = np.arctan(width / (2 * _nearest_apex(poses, height)))
    poses[:, WIDTH] = width
    poses[:, SKEW] = np.clip(poses[:, SKEW], -steepest, steepest)
    states[:, :POSE_SIZE] = poses
    if frame_count > 1:
        states[:, POSE_SIZE:] = np.gradient(poses, 1.0 / WORLD_RATE, axis=0)
    return states


def _nearest_apex(poses: FloatArray, height: float) -> FloatArray:
    """Return the least distance of the apex from the foot point, shape (N,) [px at 320 px]."""
    nearest = np.full(len(poses), NEAREST_APEX)
    if height > USUAL_HEIGHT:
        nearest = np.maximum(nearest, _distance_to_edge(poses, height) + APEX_MARGIN)
    return nearest


def _distance_to_edge(poses: FloatArray, height: float) -> FloatArray:
    """Return the distance along a centreline to the picture's edge, shape (N,) [px at 320 px].

    From the foot point, in the direction in which the borders converge; 0 or less where no part of
    the picture lies there.
    """
    distance, angle = poses[:, DISTANCE], poses[:, ANGLE]
    normal = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    onward = np.stack((-normal[:, 1], normal[:, 0]), axis=1)
    onward *= np.where(poses[:, SKEW] < 0.0, -1.0, 1.0)[:, None]
    # Where the line leaves the stripe between two opposite sides of the picture.
    half = np.array((REFERENCE_WIDTH, height)) / 2
    steps = np.where(np.abs(onward) < 1e-9, 1e-9, onward)
    distances = (np.copysign(half, steps) - distance[:, None] * normal) / steps
    nearest: FloatArray = distances.min(axis=1)
    return nearest


def _random_means(
    widths: tuple[float, float] | None, angles: tuple[float, float], rng: np.random.Generator
) -> FloatArray:
    """Draw the mean d, alpha, w, beta of a dive, shape (4,) [px, rad]."""
    if widths is None:
        width = float(np.clip(rng.normal(*PIPE_WIDTH), *PIPE_WIDTHS))
        usual = rng.normal(*PIPE_SKEW) + SKEW_OF_WIDTH * (width - PIPE_WIDTH[0])
        skew = float(np.deg2rad(np.clip(usual, *PIPE_SKEWS)))
        return np.array((rng.normal(0.0, 30.0), np.deg2rad(rng.normal(0.0, 9.0)), width, skew))
    width = float(np.exp(rng.uniform(*np.log(widths))))
    return np.array(
        (
            rng.uniform(-60.0, 60.0),
            np.deg2rad(rng.uniform(*angles)),
            width,
            np.deg2rad(rng.uniform(-1.0, 6.0)),
        )
    )


def _autocorrelated_noise(count: int, memory: float, rng: np.random.Generator) -> FloatArray:
    """Return autoregressive noise of unit variance, with a correlation time [s], shape (N, 4)."""
    correlation = float(np.exp(-1.0 / (WORLD_RATE * memory)))
    innovation = float(np.sqrt(1.0 - correlation * correlation))
    noise = rng.standard_normal((count, POSE_SIZE))
    for index in range(1, count):
        noise[index] = correlation * noise[index - 1] + innovation * noise[index]
    return noise


def _inspection_motion(means: FloatArray, count: int, rng: np.random.Generator) -> FloatArray:
    direction = _autocorrelated_noise(count, STEP_MEMORY, rng)
    scale = np.exp(np.array(INSPECTION_TAILS) * _autocorrelated_noise(count, SCALE_MEMORY, rng))
    steps = np.array(INSPECTION_STEPS) * scale * direction
    back = 1.0 / (WORLD_RATE * RETURN_TIME)
    poses = np.empty((count, POSE_SIZE))
    deviation = np.zeros(POSE_SIZE)
    for index in range(count):
        deviation = deviation * (1.0 - back) + steps[index]
        poses[index] = means + deviation
    return poses


def _lively_motion(means: FloatArray, count: int, rng: np.random.Generator) -> FloatArray:
    times = np.arange(count) / WORLD_RATE
    limits = np.array(LIVELY_LIMITS) * (1.0, 1.0, means[WIDTH], 1.0)
    swings = [
        Harmonics.random(float(limit), LIVELY_BANDS, rng).values(times) * rng.uniform(0.4, 1.0)
        for limit in limits
    ]
    return means + np.stack(swings, axis=1)
