"""Write a simulated dive into a bag, with what the vehicle's instruments say of it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from cable_tracker.sequences.bags.bag_writer import BagWriter, StorageFormat
from cable_tracker.sequences.bags.convert import write_frame
from cable_tracker.sequences.frame import Frame
from cable_tracker.simulation.dive import Dive
from cable_tracker.simulation.instruments.instrument_writer import (
    FIX_SIGMA,
    InstrumentWriter,
    Tick,
    vehicle_text,
)
from cable_tracker.simulation.instruments.instruments import InstrumentErrors, InstrumentSet
from cable_tracker.simulation.motion.flight import vehicle_states_at

READING_RATE = 50.0
"""Odometry and imu speak about so often [1/s]."""

MOST_READINGS = 200
"""Largest number of readings of each instrument between two frames."""


def write_instrumented_bag(
    path: Path,
    frames: Iterable[Frame],
    dive: Dive,
    rate: float,
    seed: int,
    *,
    storage: StorageFormat = StorageFormat.MCAP,
    overwrite: bool = False,
) -> int:
    """Write the frames of a dive, and calibration, altitude, imu, odometry, fixes and mounting.

    The altimeter is read with each frame; a fix comes with the first frame in each second.

    Parameters
    ----------
    path : Path
        Folder of the bag; gets a `vehicle.yaml` with what no topic says.
    frames : iterable of Frame
        Frames of the dive, from its beginning.
    dive : Dive
        Dive with the vehicle's poses.
    rate : float
        Frames per second.
    seed : int
        Not negative; draws the errors of the instruments.
    overwrite : bool
        Replace a bag that lies at the path.

    Returns
    -------
    int
        Number of frames.

    Raises
    ------
    OutputError
        The bag cannot be written.
    """
    readings = int(np.clip(round(READING_RATE / rate), 1, MOST_READINGS))
    errors, rng = InstrumentErrors(), np.random.default_rng([seed, 30])
    count = 0
    vehicle = vehicle_text(dive.tube.height).encode()
    with BagWriter(path, storage, overwrite=overwrite, vehicle=vehicle) as bag:
        writer = InstrumentWriter(bag, dive.camera, errors)
        instruments: InstrumentSet | None = None
        for frame in frames:
            times = (count + np.arange(readings) / readings) / rate
            states = vehicle_states_at(dive, times)
            if instruments is None:
                instruments = InstrumentSet(errors, states[0], rng)
            for number, (seconds, state) in enumerate(zip(times, states, strict=True)):
                # Odometry counts the time since the reading before.
                elapsed = 1.0 / (rate * readings) if count or number else 0.0
                is_fixed = count == 0 or int(count / rate) > int((count - 1) / rate)
                fix = None
                if number == 0 and is_fixed:
                    fix = state.position[:2] + FIX_SIGMA * rng.standard_normal(2)
                altitude = instruments.altitude(state) if number == 0 else None
                odometry, imu = instruments.odometry(state, elapsed), instruments.imu(state)
                writer.write(Tick(float(seconds), state, odometry, imu, altitude, fix))
            write_frame(bag, frame)
            count += 1
    return count
