"""`cable-tracker warm-up`."""

from __future__ import annotations

import time

from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.commands.terminal import console
from cable_tracker.target.parameters.presets import TARGET_PRESETS
from cable_tracker.target.warming import warm_up_target
from cable_tracker.trackers import warm_up


def warm_up_command() -> None:
    """Compile beforehand what the trackers need."""
    begin = time.perf_counter()
    for parameters in PRESETS.values():
        warm_up(parameters)
    for target_parameters in TARGET_PRESETS.values():
        warm_up_target(target_parameters)
    console.print(f"the inner loops are compiled ({time.perf_counter() - begin:.0f} s)")
