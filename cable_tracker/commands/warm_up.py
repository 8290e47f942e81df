"""`cable-tracker warm-up`."""

from __future__ import annotations

import time

from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.commands.terminal import console
from cable_tracker.compilation import NUMBA_IS_INSTALLED
from cable_tracker.trackers import warm_up


def warm_up_command() -> None:
    """Compile the inner loops now, so that nothing waits later."""
    if not NUMBA_IS_INSTALLED:
        console.print("Numba is not installed: the inner loops run in NumPy, nothing to compile")
        return
    begin = time.perf_counter()
    for parameters in PRESETS.values():
        warm_up(parameters)
    console.print(f"the inner loops are compiled ({time.perf_counter() - begin:.0f} s)")
