"""Results of one benchmark, with linear fits through its times, and their JSON file."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from cable_tracker.benchmark.cases import REFERENCE_PARTICLES, Accuracy
from cable_tracker.benchmark.contours import ContourTiming
from cable_tracker.benchmark.footage import RENDERED_SIZE
from cable_tracker.benchmark.fresh_processes import MemoryUse, StartTime
from cable_tracker.benchmark.node_timing import NodeTiming
from cable_tracker.benchmark.profiling import ProfileRow
from cable_tracker.benchmark.round_robin import CaseLabel, Measurement
from cable_tracker.benchmark.statistics import fit_line

NANOSECONDS_PER_MS = 1e6

FORMAT = "cable_tracker benchmark 1"


@dataclass(frozen=True, slots=True)
class Growth:
    """Linear fit of the median time of a frame over one variable.

    Attributes
    ----------
    name : str
        The preset.
    variable : str
        Independent variable: particle, image pixel, sample point.
    base : float
        Time of a frame with none of it [ms].
    each : float
        Time for one more [ns].
    points : int
        Number of measurements that the line is fitted to.
    """

    name: str
    variable: str
    base: float
    each: float
    points: int


@dataclass(frozen=True, slots=True)
class _Variable:
    name: str
    belongs: Callable[[CaseLabel], bool]
    amount: Callable[[CaseLabel], float]


VARIABLES = (
    _Variable(
        "particle",
        lambda label: label.section == "frame" and label.size == RENDERED_SIZE,
        lambda label: float(label.particles or 0),
    ),
    _Variable(
        "image pixel",
        lambda label: label.section == "frame" and label.particles == REFERENCE_PARTICLES,
        lambda label: float(math.prod(label.size)),
    ),
    _Variable("sample point", lambda label: label.section == "spacing", lambda label: label.amount),
)


def fit_growth(measurements: Sequence[Measurement]) -> list[Growth]:
    """Fit a line for each preset and each variable with two points or more.

    Sample points are those of all particles together.
    """
    filters = dict.fromkeys(m.label.name for m in measurements if m.label.section == "frame")
    fits = []
    for name in filters:
        own = [
            (m.label, m.cpu.median)
            for m in measurements
            if m.label.name == name and m.cpu is not None
        ]
        for variable in VARIABLES:
            pairs = [(variable.amount(label), ms) for label, ms in own if variable.belongs(label)]
            if len({amount for amount, _ in pairs}) < 2:
                continue
            base, slope = fit_line([amount for amount, _ in pairs], [ms for _, ms in pairs])
            each = slope * NANOSECONDS_PER_MS
            fits.append(Growth(name, variable.name, base, each, len(pairs)))
    return fits


@dataclass(frozen=True, slots=True)
class Circumstances:
    """Where, when and how it was measured.

    Attributes
    ----------
    command, date, machine, versions : str
        For people.
    load_before, load_after : tuple of float
        Load averages of the machine over 1, 5 and 15 minutes.
    absent : tuple of str
        Libraries to compare with that are not installed.
    """

    command: str
    date: str
    machine: str
    versions: str
    load_before: tuple[float, float, float]
    load_after: tuple[float, float, float]
    absent: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BenchmarkResult:
    """Results of a benchmark.

    Attributes
    ----------
    circumstances : Circumstances
        Machine, date and versions.
    measurements : tuple of Measurement
        All times of functions and frames.
    accuracies : tuple of Accuracy
        Errors of the methods on the same frames.
    growths : tuple of Growth
        Linear fits of the time of a frame.
    profile : tuple of ProfileRow
        Profile of the preset's functions.
    memory : tuple of MemoryUse
        Whether memory grows.
    nodes : tuple of NodeTiming
        Node to node; empty if that was not asked for.
    starts : tuple of StartTime
        Start time of each preset; empty if it was not asked for.
    contours : tuple of ContourTiming
        Times of contour evolution; empty if they were not asked for.
    """

    circumstances: Circumstances
    measurements: tuple[Measurement, ...]
    accuracies: tuple[Accuracy, ...]
    growths: tuple[Growth, ...]
    profile: tuple[ProfileRow, ...]
    memory: tuple[MemoryUse, ...]
    nodes: tuple[NodeTiming, ...] = ()
    starts: tuple[StartTime, ...] = ()
    contours: tuple[ContourTiming, ...] = ()

    def of(self, section: str) -> list[Measurement]:
        """Return the measurements of a section."""
        return [m for m in self.measurements if m.label.section == section]

    def find(self, label: CaseLabel) -> Measurement | None:
        """Return the measurement of this; None if there is none, or it was left out."""
        for measurement in self.measurements:
            if measurement.label == label and measurement.cpu is not None:
                return measurement
        return None


def to_json(result: BenchmarkResult) -> str:
    """Return all numbers as JSON; `None` where something was left out."""
    content: dict[str, Any] = {"format": FORMAT, **asdict(result)}
    return json.dumps(content, indent=1) + "\n"


def is_benchmark(path: Path) -> bool:
    """Tell whether a file was written by `to_json`."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(content, dict) and content.get("format") == FORMAT
