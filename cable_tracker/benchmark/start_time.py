"""Start time of a tracker: with an empty and with a full cache of machine code."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass

PROGRAM = """
import time
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.trackers import warm_up
warm_up(preset({name!r}))
print(time.process_time())
"""


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
