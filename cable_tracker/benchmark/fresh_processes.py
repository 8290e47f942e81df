"""Measurements in fresh processes: time of a start, and growth of memory over many frames."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from cable_tracker.benchmark.footage import RENDERED_SIZE, Footage, FrameLoop, footage
from cable_tracker.benchmark.statistics import fit_line
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.evaluation.methods import ConfiguredFilter
from cable_tracker.libraries import one_thread

PROGRAM = """
import time
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.trackers import warm_up
warm_up(preset({name!r}))
print(time.process_time())
"""

STATUS = Path("/proc/self/statm")
KIB = 1024
SAMPLES = 40
"""Number of samples of the memory after the warm-up."""

WARM_UP_SHARE, LONGEST_WARM_UP = 0.2, 2000
"""Share of the frames, and number of them at most, before the memory counts."""


@dataclass(frozen=True, slots=True)
class StartTime:
    """Time of the processor from the start of Python until a preset is warmed up [s].

    Attributes
    ----------
    name : str
        The preset.
    cold, warm : float
        Start times with an empty folder for machine code, and with the one that the first start
        has filled.
    """

    name: str
    cold: float
    warm: float


def measure_start(name: str) -> StartTime:
    """Start two fresh processes, one after the other, with a folder of their own."""
    with tempfile.TemporaryDirectory() as folder:
        cold = _start(name, folder)
        return StartTime(name, cold, _start(name, folder))


def _start(name: str, folder: str) -> float:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(name=name)],
        check=True,
        capture_output=True,
        text=True,
        env=os.environ | {"NUMBA_CACHE_DIR": folder},
    )
    return float(done.stdout)


@dataclass(frozen=True, slots=True)
class MemoryUse:
    """Resident memory of the process while one preset tracks.

    Attributes
    ----------
    name : str
        The preset.
    frames : int
        After the warm-up.
    start, growth : float
        Memory after the warm-up, and the mean of the last quarter less that of the first [MiB].
    per_thousand : float
        Slope of a straight line through all samples [KiB per 1000 frames].
    """

    name: str
    frames: int
    start: float
    growth: float
    per_thousand: float


def resident_bytes() -> int:
    """Return the memory of this process that is in use now [bytes]."""
    if STATUS.is_file():
        return int(STATUS.read_text(encoding="ascii").split()[1]) * resource.getpagesize()
    # Elsewhere only the largest use so far is known, which shows growth as well.
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * KIB


def measure_memory(name: str, shown: Footage, frames: int) -> MemoryUse:
    """Track some frames with a preset, at least a few dozen, and sample the resident memory."""
    loop = FrameLoop(ConfiguredFilter(name, preset(name)).make(0), shown)
    warm_up = min(int(WARM_UP_SHARE * frames), LONGEST_WARM_UP)
    _run(loop, warm_up)
    left = frames - warm_up
    stops = np.unique(np.linspace(0, left, SAMPLES + 1).astype(int))
    samples = [resident_bytes()]
    for before, after in pairwise(stops):
        _run(loop, int(after - before))
        samples.append(resident_bytes())
    sizes = np.array(samples, np.float64)
    quarter = max(len(sizes) // 4, 1)
    _, slope = fit_line([float(stop) for stop in stops], list(sizes))
    return MemoryUse(
        name,
        left,
        sizes[0] / KIB**2,
        float(sizes[-quarter:].mean() - sizes[:quarter].mean()) / KIB**2,
        slope * 1000 / KIB,
    )


def measure_memory_in_fresh_process(name: str, footage_frames: int, frames: int) -> MemoryUse:
    """Call `measure_memory` in a fresh process: memory freed earlier would hide growth."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(_measure_in_this_process, name, footage_frames, frames).result()


def _measure_in_this_process(name: str, footage_frames: int, frames: int) -> MemoryUse:
    with one_thread():
        return measure_memory(name, footage(footage_frames, RENDERED_SIZE), frames)


def _run(loop: FrameLoop, frames: int) -> None:
    for _ in range(frames):
        loop()
