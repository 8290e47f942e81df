"""Which functions a frame spends its time in."""

from __future__ import annotations

import cProfile
import pstats
from dataclasses import dataclass
from pathlib import Path

from cable_tracker.benchmark.footage import Footage, FrameLoop
from cable_tracker.benchmark.round_robin import WARM_UP_CALLS
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.evaluation.methods import ConfiguredFilter

MOST_ROWS = 8
PACKAGE = "cable_tracker"


@dataclass(frozen=True, slots=True)
class ProfileRow:
    """A function and its own time, without that of what it calls.

    Attributes
    ----------
    name : str
        The preset.
    function : str
        Module and function; compiled ones count as part of the function that calls them.
    share : float
        Share of the time of all functions [%].
    ms : float
        Per frame, under the profiler [ms].
    calls : float
        Per frame.
    """

    name: str
    function: str
    share: float
    ms: float
    calls: float


def profile_preset(name: str, shown: Footage, frames: int) -> list[ProfileRow]:
    """Return the functions that take most of a preset's time, most first.

    The profiler slows small functions down more than large ones; the shares are a hint.
    """
    loop = FrameLoop(ConfiguredFilter(name, preset(name)).make(0), shown)
    for _ in range(WARM_UP_CALLS):
        loop()
    profiler = cProfile.Profile()
    profiler.enable()
    for _ in range(frames):
        loop()
    profiler.disable()
    entries = pstats.Stats(profiler).stats  # type: ignore[attr-defined]
    total = sum(own for _, _, own, _, _ in entries.values())
    rows = [
        ProfileRow(name, _named(place), 100 * own / total, 1e3 * own / frames, calls / frames)
        for place, (_, calls, own, _, _) in entries.items()
    ]
    return sorted(rows, key=lambda row: -row.share)[:MOST_ROWS]


def _named(place: tuple[str, int, str]) -> str:
    """Return module and function without the folders of this machine."""
    file, _, function = place
    parts = Path(file).with_suffix("").parts
    if PACKAGE in parts:
        last = len(parts) - 1 - parts[::-1].index(PACKAGE)
        return f"{'.'.join(parts[last + 1 :])}.{function}"
    if file in ("~", ""):
        return function.strip("<>").removeprefix("built-in method ").split(" of ")[0]
    return f"{'.'.join(parts[-2:])}.{function}"
