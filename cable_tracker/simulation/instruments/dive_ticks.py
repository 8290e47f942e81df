"""What the instruments of a vehicle say on a simulated dive that has no vehicle of its own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from cable_tracker.sequences.frame import Frame
from cable_tracker.simulation.dive import Dive
from cable_tracker.simulation.instruments.instrument_writer import FIX_SIGMA, Tick
from cable_tracker.simulation.instruments.instruments import InstrumentErrors, InstrumentSet
from cable_tracker.simulation.motion.flight import vehicle_states_at

READING_RATE = 50.0
"""Odometry and imu speak about so often [1/s]."""

MOST_READINGS = 200
"""Largest number of readings of each instrument between two frames."""


def dive_ticks(frames: Iterable[Frame], dive: Dive, rate: float, seed: int) -> Iterator[Tick]:
    """Yield what the instruments say with each frame of a dive, and until the next one.

    The altimeter is read with each frame; a fix comes with the first frame in each second.

    Parameters
    ----------
    frames : iterable of Frame
        Frames of the dive, from its beginning.
    rate : float
        Frames per second.
    seed : int
        Not negative; draws the errors of the instruments.
    """
    readings = int(np.clip(round(READING_RATE / rate), 1, MOST_READINGS))
    rng = np.random.default_rng([seed, 30])
    start = vehicle_states_at(dive, np.zeros(1))[0]
    instruments = InstrumentSet(InstrumentErrors(), start, rng)
    for count, frame in enumerate(frames):
        times = (count + np.arange(readings) / readings) / rate
        for number, state in enumerate(vehicle_states_at(dive, times)):
            fix = altitude = None
            if number == 0:
                if count == 0 or int(count / rate) > int((count - 1) / rate):
                    fix = state.position[:2] + FIX_SIGMA * rng.standard_normal(2)
                altitude = instruments.altitude(state)
            # Odometry counts the time since the reading before.
            elapsed = 1.0 / (rate * readings) if count or number else 0.0
            odometry, imu = instruments.odometry(state, elapsed), instruments.imu(state)
            picture = None if number else frame
            yield Tick(float(times[number]), state, odometry, imu, altitude, fix, picture)
