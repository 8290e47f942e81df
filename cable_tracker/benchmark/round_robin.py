"""Timing in turns: blocks of all cases alternate, each next to a block of the yardstick.

Load by others on a shared machine then slows the yardstick and the case beside it alike.
Times are those of the processor that this process used: waiting while others run does not count.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from cable_tracker.benchmark.statistics import Quartiles

YARDSTICK_CALLS = 5
"""Calls of the yardstick beside each block."""

WARM_UP_CALLS = 4
"""Calls before anything is timed: they compile, load and allocate."""

FEWEST_ROUNDS = 3
MOST_CALLS = 20
"""Calls in a block, at most."""

SECTIONS = ("yardstick", "copy", "step", "frame", "spacing", "method", "library")
"""Sections of the timed cases: the yardstick itself, copies of memory, steps of the filters,
whole frames, whole frames at other distances between sample points, detectors with a Kalman filter,
and one filter on libraries."""

Step = Callable[[], object]
Advance = Callable[[int], None]


@dataclass(frozen=True, slots=True)
class CaseLabel:
    """Label of a timed case.

    Attributes
    ----------
    section : str
        Section of the case: one of `SECTIONS`.
    name : str
        The preset, the method, or the step.
    size : (int, int)
        Width and height of the frames [px].
    particles : int or None
        Number of particles; None where there are none.
    amount : float
        Sample points of all particles in the section `spacing`, bytes in the section `copy`.
    """

    section: str
    name: str
    size: tuple[int, int]
    particles: int | None = None
    amount: float = 0.0

    @property
    def family(self) -> tuple[object, ...]:
        """Label without the number of particles: section, name, size, amount."""
        return self.section, self.name, self.size, self.amount


@dataclass(frozen=True, slots=True)
class BenchmarkCase:
    """Operation to be timed.

    Attributes
    ----------
    label : CaseLabel
        Label of the case in tables.
    prepare : callable
        Returns the step that is called repeatedly; called when the case is warmed up.
    """

    label: CaseLabel
    prepare: Callable[[], Step]


@dataclass(frozen=True, slots=True)
class Measurement:
    """Measured time of a case.

    Attributes
    ----------
    label : CaseLabel
        Label of the case in tables.
    cpu : Quartiles or None
        Time of the processor per call [ms]; None if it was left out.
    wall : Quartiles or None
        Time on the clock per call [ms].
    ratio : Quartiles or None
        Median of a block over that of the yardstick's block beside it.
    skipped : str
        Reason why it was left out.
    """

    label: CaseLabel
    cpu: Quartiles | None = None
    wall: Quartiles | None = None
    ratio: Quartiles | None = None
    skipped: str = ""


@dataclass(frozen=True, slots=True)
class Effort:
    """Effort of a measurement.

    Attributes
    ----------
    rounds : int
        Blocks of each case.
    block : float
        Wanted length of a block [s]; at least one call.
    budget : float
        Time after which a case takes no further turn, but for the first three [s].
    longest : float
        Longest time of a call of a case that is not left out [s].
    """

    rounds: int = 20
    block: float = 0.015
    budget: float = 2.0
    longest: float = 1.0


@dataclass(slots=True)
class _CaseTimes:
    """One case, its times so far, and the number of calls in its blocks."""

    case: BenchmarkCase
    step: Step
    calls: int
    cpu: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)

    def is_due(self, effort: Effort) -> bool:
        return len(self.ratios) < FEWEST_ROUNDS or sum(self.wall) < effort.budget

    def time_block(self, yardstick: Step) -> None:
        reference, _ = timed_block(yardstick, YARDSTICK_CALLS)
        cpu, wall = timed_block(self.step, self.calls)
        self.cpu += cpu
        self.wall += wall
        self.ratios.append(float(np.median(cpu) / np.median(reference)))

    def measurement(self) -> Measurement:
        return Measurement(
            self.case.label,
            Quartiles.of(1e3 * np.array(self.cpu)),
            Quartiles.of(1e3 * np.array(self.wall)),
            Quartiles.of(self.ratios),
        )


def timed_block(step: Step, calls: int) -> tuple[list[float], list[float]]:
    """Return the processor's and the clock's time of each of some calls [s]."""
    cpu, wall = [], []
    for _ in range(calls):
        clock, begin = time.perf_counter(), time.process_time()
        step()
        cpu.append(time.process_time() - begin)
        wall.append(time.perf_counter() - clock)
    return cpu, wall


def measure_in_turns(
    cases: Sequence[BenchmarkCase],
    yardstick: Step,
    effort: Effort,
    advance: Advance = lambda count: None,
) -> list[Measurement]:
    """Time all cases in turns.

    Parameters
    ----------
    cases : sequence of BenchmarkCase
        Cases; within a family, ordered by increasing number of particles.
    yardstick : callable
        Reference operation that is timed beside each case.
    effort : Effort
        Rounds and time spent on each case.
    advance : callable
        Called with the number of further turns done, ``effort.rounds`` for each case in the end.

    Returns
    -------
    list of Measurement
        One for each case, in their order.
    """
    timed_block(yardstick, WARM_UP_CALLS)
    running: list[_CaseTimes | Measurement] = []
    shortest_calls: dict[tuple[object, ...], tuple[int, float]] = {}
    for case in cases:
        ready = _warm_up(case, shortest_calls, effort)
        running.append(ready)
        if isinstance(ready, Measurement):
            advance(effort.rounds)
    for _ in range(effort.rounds):
        for times in running:
            if isinstance(times, Measurement):
                continue
            if times.is_due(effort):
                times.time_block(yardstick)
            advance(1)
    return [each if isinstance(each, Measurement) else each.measurement() for each in running]


def _warm_up(
    case: BenchmarkCase, shortest_calls: dict[tuple[object, ...], tuple[int, float]], effort: Effort
) -> _CaseTimes | Measurement:
    """Make a case ready, or leave it out; `shortest_calls` has particles and time [s] by family."""
    label = case.label
    if label.particles and label.family in shortest_calls:
        fewer, before = shortest_calls[label.family]
        expected = before * label.particles / fewer
        if expected > effort.longest:
            return Measurement(label, skipped=f"left out: about {expected:.1f} s")
    step = case.prepare()
    _, wall = timed_block(step, WARM_UP_CALLS)
    shortest = min(wall)
    if label.particles:
        shortest_calls[label.family] = (label.particles, shortest)
    if shortest > effort.longest:
        return Measurement(label, skipped=f"left out: {shortest:.1f} s")
    return _CaseTimes(case, step, int(np.clip(effort.block / max(shortest, 1e-9), 1, MOST_CALLS)))
