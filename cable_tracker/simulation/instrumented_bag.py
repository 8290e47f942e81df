"""Write a simulated dive into a bag, with what the vehicle's instruments say of it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Literal

import numpy as np

from cable_tracker.sequences.bag_writer import BagWriter
from cable_tracker.sequences.convert import write_frame
from cable_tracker.sequences.frame import Frame
from cable_tracker.simulation.dive import Dive
from cable_tracker.simulation.flight import motions_at
from cable_tracker.simulation.instruments import InstrumentErrors, InstrumentSet
from cable_tracker.simulation.survey_bag import VEHICLE, InstrumentWriter, vehicle_text
from cable_tracker.simulation.survey_dive import FIX_SIGMA, Tick
from cable_tracker.simulation.vehicle import VehicleState

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
    storage: Literal["sqlite3", "mcap"] = "mcap",
    overwrite: bool = False,
) -> int:
    """Write the frames of a dive, and calibration, altitude, imu, odometry, fixes and mounting.

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
    with BagWriter(path, storage, overwrite=overwrite) as bag:
        writer = InstrumentWriter(bag, dive.camera, errors)
        instruments: InstrumentSet | None = None
        for frame in frames:
            times = (count + np.arange(readings) / readings) / rate
            motions = motions_at(dive, times)
            if instruments is None:
                instruments = InstrumentSet(errors, motions[0], rng)
            for number, (seconds, motion) in enumerate(zip(times, motions, strict=True)):
                tick = _tick(float(seconds), motion, instruments, rng, (number == 0, count, rate))
                writer.write(tick)
            write_frame(bag, frame)
            count += 1
    (path / VEHICLE).write_text(vehicle_text(dive.tube.height), encoding="utf-8")
    return count


def _tick(
    seconds: float,
    motion: VehicleState,
    instruments: InstrumentSet,
    rng: np.random.Generator,
    frame: tuple[bool, int, float],
) -> Tick:
    """Read the instruments; altimeter with each frame, and a fix with the first in each second."""
    is_frame, count, rate = frame
    period = 0.0
    if count or not is_frame:
        period = 1.0 / (rate * int(np.clip(round(READING_RATE / rate), 1, MOST_READINGS)))
    is_new_second = (is_frame and int(count / rate) > int((count - 1) / rate)) or count == 0
    fix = None
    if is_frame and is_new_second:
        fix = motion.position[:2] + FIX_SIGMA * rng.standard_normal(2)
    altitude = instruments.altitude(motion) if is_frame else None
    return Tick(
        seconds,
        motion,
        instruments.odometry(motion, period),
        instruments.imu(motion),
        altitude,
        fix,
    )
