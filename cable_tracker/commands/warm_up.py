"""`cable-tracker warm-up`."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator

from cable_tracker.cable.parameters.presets import PRESETS
from cable_tracker.commands.console.terminal import console
from cable_tracker.errors import ParameterError
from cable_tracker.target.parameters.presets import TARGET_PRESETS
from cable_tracker.target.tracker import warm_up_target
from cable_tracker.trackers import warm_up
from cable_tracker.tracking.parameter_table import Parameters, parameter_table


def variants(presets: Iterable[Parameters]) -> Iterator[Parameters]:
    """Yield presets, and what changing one choice among their parameters makes of them.

    Choices tell which code runs: with all of them compiled, a node need not compile anything when
    one is changed while it runs. Parameters with the same choices come once.
    """
    seen: set[tuple[str, ...]] = set()
    for preset in presets:
        chosen = [spec for spec in parameter_table(type(preset)) if spec.choices]
        changes = [
            _replaced(preset, spec.name, choice) for spec in chosen for choice in spec.choices
        ]
        for parameters in (preset, *changes):
            if parameters is not None and parameters.choices() not in seen:
                seen.add(parameters.choices())
                yield parameters


def _replaced(preset: Parameters, name: str, word: str) -> Parameters | None:
    """Return a preset with another word; None if it does not go with the preset's others."""
    try:
        return preset.replaced({name: word})
    except ParameterError:
        return None


def warm_up_command() -> None:
    """Compile beforehand what the trackers need."""
    begin = time.perf_counter()
    for parameters in variants(PRESETS.values()):
        warm_up(parameters)
    for target_parameters in variants(TARGET_PRESETS.values()):
        warm_up_target(target_parameters)
    console.print(f"the inner loops are compiled ({time.perf_counter() - begin:.0f} s)")
