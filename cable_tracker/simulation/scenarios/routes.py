"""Trajectories drawn at random: of the plain simulation, and of the scenarios."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cable_tracker.arrays import FloatArray
from cable_tracker.simulation.motion.trajectory import (
    Bands,
    Harmonics,
    Pause,
    Signal,
    Trajectory,
)
from cable_tracker.simulation.scenarios.scenario import SCENARIO_RATE, ComponentMotion, Scenario

DISTANCE_LIMIT = 70.0
"""Largest |d| of the plain simulation [px at the reference width]."""

ANGLE_LIMIT = float(np.deg2rad(25.0))
"""Largest |alpha| [rad]."""

WIDTH_LIMITS = (24.0, 48.0)
"""Smallest and largest w [px at the reference width]."""

SKEW_LIMITS = (float(np.deg2rad(1.0)), float(np.deg2rad(3.2)))
"""Smallest and largest beta [rad]; the borders meet outside a 4:3 image."""

SPEED_LIMITS = (0.2, 0.36)
"""Forward speed [m/s]."""

ROLL_LIMIT = float(np.deg2rad(2.5))
"""Largest roll of the vehicle [rad]."""

SURGE_LIMIT = 0.06
"""Largest distance of the vehicle before or behind its steady motion [m]."""

SHARES = (0.3, 0.4, 0.2, 0.1)
"""Shares of the limit that the sinusoids take: slow wandering first, then faster and smaller."""

SWAY_BANDS: Bands = ((0.008, 0.03), (0.12, 0.2), (0.25, 0.45), (0.5, 0.75))
"""Frequencies of the sinusoids of d and alpha [Hz]."""

DRIFT_BANDS: Bands = ((0.008, 0.02), (0.03, 0.06), (0.07, 0.12), (0.15, 0.2))
"""Frequencies of the sinusoids of altitude and tilt [Hz]."""

ROLL_BANDS: Bands = ((0.1, 0.15), (0.25, 0.35), (0.5, 0.7))
"""Frequencies of the sinusoids of the roll [Hz]."""

BRAKING_TIME = 1.0
"""Time in which a vehicle stops, or gets under way again [s]."""

ATTEMPTS = 40
"""Number of draws of a motion before one that exceeds its limits is given up."""


def random_trajectory(rng: np.random.Generator) -> Trajectory:
    """Draw the trajectory of the plain simulation: wandering, within limits, for ever."""
    narrowest, widest = WIDTH_LIMITS
    low, high = SKEW_LIMITS
    return Trajectory(
        distance=_wander(0.0, DISTANCE_LIMIT, SWAY_BANDS, rng),
        angle=_wander(0.0, ANGLE_LIMIT, SWAY_BANDS, rng),
        width=_wander((widest + narrowest) / 2, (widest - narrowest) / 2, DRIFT_BANDS, rng),
        skew=_wander((high + low) / 2, (high - low) / 2, DRIFT_BANDS, rng),
        roll=_random_roll(rng),
        surge=_wander(0.0, SURGE_LIMIT, DRIFT_BANDS, rng),
        speed=float(rng.uniform(*SPEED_LIMITS)),
    )


def _wander(mean: float, limit: float, bands: Bands, rng: np.random.Generator) -> Signal:
    return Signal(mean, Harmonics.random(limit, bands, rng, SHARES))


def _random_roll(rng: np.random.Generator) -> Signal:
    return Signal(0.0, Harmonics.random(ROLL_LIMIT, ROLL_BANDS, rng))


def scenario_trajectory(scenario: Scenario, rng: np.random.Generator) -> Trajectory:
    """Draw the trajectory of a scenario, with the frame-to-frame variances that it asks for."""
    motion = scenario.motion
    times = np.arange(scenario.frame_count) / SCENARIO_RATE
    radian = float(np.deg2rad(1.0))
    pause = None
    if motion.stop is not None:
        first, last = (frame / SCENARIO_RATE for frame in motion.stop)
        pause = Pause(first, last, BRAKING_TIME)
    return Trajectory(
        distance=_random_signal(motion.distance, 1.0, times, rng),
        angle=_random_signal(motion.angle, radian, times, rng),
        width=_random_signal(motion.width, 1.0, times, rng),
        skew=_random_signal(motion.skew, radian, times, rng),
        roll=_random_roll(rng),
        surge=Signal(0.0, Harmonics.random(0.0, DRIFT_BANDS, rng)),
        speed=motion.speed,
        pause=pause,
    )


def _random_signal(
    motion: ComponentMotion, unit: float, times: FloatArray, rng: np.random.Generator
) -> Signal:
    """Draw a signal until its oscillation keeps within its limit; the calmest of many otherwise."""
    best, smallest = None, np.inf
    for _ in range(ATTEMPTS):
        signal = Signal(
            unit * motion.mean,
            Harmonics.random(unit * motion.limit, motion.bands, rng),
            tuple(replace(move, amount=unit * move.amount) for move in motion.moves),
            motion.strength,
        )
        if motion.variance is None:
            return signal
        signal = signal.with_increment_variance(unit**2 * motion.variance, times)
        reach = float(np.abs(signal.oscillation(times)).max())
        if reach < smallest:
            best, smallest = signal, reach
        if reach <= unit * motion.limit:
            break
    assert best is not None
    return best
