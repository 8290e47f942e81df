"""Plan of a benchmark, and the benchmark itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version

from cable_tracker.benchmark.cases import (
    TIMED_PRESETS,
    copy_cases,
    frame_cases,
    measure_accuracy,
    rival_cases,
    spacing_cases,
    step_cases,
    yardstick_case,
)
from cable_tracker.benchmark.contours import measure_contour
from cable_tracker.benchmark.footage import RENDERED_SIZE, Footage, footage
from cable_tracker.benchmark.fresh_processes import (
    MemoryUse,
    measure_memory_in_fresh_process,
    measure_start,
)
from cable_tracker.benchmark.library_filters import LIBRARY_LOOPS, is_installed
from cable_tracker.benchmark.profiling import profile_preset
from cable_tracker.benchmark.result import BenchmarkResult, Circumstances, fit_growth
from cable_tracker.benchmark.round_robin import (
    Advance,
    BenchmarkCase,
    Effort,
    measure_in_turns,
)
from cable_tracker.benchmark.yardstick import make_yardstick
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import ParameterError
from cable_tracker.libraries import one_thread
from cable_tracker.trackers import warm_up

SMALLEST_MEMORY_RUN = 50
"""Smallest number of frames for a measurement of memory."""

VERSIONS = ("numba", "particles", "filterpy", "rclpy")
"""Packages whose versions are named besides the line about the machine."""


@dataclass(frozen=True, slots=True)
class Plan:
    """Plan of a benchmark.

    Attributes
    ----------
    frames : int
        Frames of the dive.
    sizes : tuple of (int, int)
        Widths and heights [px]; the first is 320x240, on which all but whole frames is measured.
    particles : tuple of int
        Numbers of particles; 500 among them.
    effort : Effort
        Rounds and time spent on each case.
    profiled : int
        Frames under the profiler.
    memory : int
        Frames over which memory is watched, for each preset; 0 leaves it out.
    starts : bool
        Whether each preset is started in fresh processes, cold and warm.
    contours : bool
        Whether contours are compared with scikit-image's.
    """

    frames: int = 60
    sizes: tuple[tuple[int, int], ...] = (RENDERED_SIZE, (640, 480), (1280, 720), (1920, 1080))
    particles: tuple[int, ...] = (300, 500, 2000, 10_000, 100_000)
    effort: Effort = field(default_factory=Effort)
    profiled: int = 200
    memory: int = 10_000
    starts: bool = True
    contours: bool = True


FULL = Plan()
QUICK = Plan(
    frames=30,
    sizes=(RENDERED_SIZE, (1920, 1080)),
    particles=(500, 2000, 10_000),
    effort=Effort(rounds=8, budget=0.5),
    profiled=50,
    memory=0,
    starts=False,
    contours=False,
)


class Benchmark:
    """A plan, ready to be run.

    Parameters
    ----------
    plan : Plan
        Cases and effort of the benchmark.

    Raises
    ------
    ParameterError
        Too few frames are to be watched.
    """

    def __init__(self, plan: Plan) -> None:
        if 0 < plan.memory < SMALLEST_MEMORY_RUN:
            raise ParameterError(
                f"memory is {plan.memory}: give 0, or at least {SMALLEST_MEMORY_RUN} frames"
            )
        self._plan = plan
        self._footages = [footage(plan.frames, size) for size in plan.sizes]
        shown = self._footages[0]
        self._yardstick = make_yardstick(shown.images[0], shown.truths[0])
        for name in TIMED_PRESETS:
            warm_up(preset(name))
        self._cases = self._make_cases(shown)

    def _make_cases(self, shown: Footage) -> list[BenchmarkCase]:
        return [
            yardstick_case(self._yardstick),
            *copy_cases(self._yardstick, self._footages),
            *step_cases(shown),
            *rival_cases(shown),
            *spacing_cases(shown),
            *frame_cases(self._footages, self._plan.particles),
        ]

    def turn_count(self) -> int:
        """Return the total of turns and frames that `advance` is called with."""
        memory = self._plan.memory * len(TIMED_PRESETS)
        return len(self._cases) * self._plan.effort.rounds + memory

    def run(
        self, circumstances: Circumstances, advance: Advance = lambda count: None
    ) -> BenchmarkResult:
        """Measure all but nodes, in one thread."""
        plan, shown = self._plan, self._footages[0]
        with one_thread():
            measurements = measure_in_turns(self._cases, self._yardstick, plan.effort, advance)
            accuracies = measure_accuracy(plan.frames)
            profile = [
                row for name in TIMED_PRESETS for row in profile_preset(name, shown, plan.profiled)
            ]
            memory: list[MemoryUse] = []
            for name in TIMED_PRESETS if plan.memory else ():
                memory.append(measure_memory_in_fresh_process(name, plan.frames, plan.memory))
                advance(plan.memory)
            return BenchmarkResult(
                circumstances,
                measurements=tuple(measurements),
                accuracies=tuple(accuracies),
                growths=tuple(fit_growth(measurements)),
                profile=tuple(profile),
                memory=tuple(memory),
                starts=tuple(measure_start(name) for name in TIMED_PRESETS) if plan.starts else (),
                contours=(measure_contour(),) if plan.contours else (),
            )


def absent_libraries() -> tuple[str, ...]:
    """Return the libraries to compare with that are not installed."""
    return tuple(name for name in LIBRARY_LOOPS if not is_installed(name))


def versions() -> str:
    """Return the versions of further packages that times depend on, in one line."""
    known = []
    for name in VERSIONS:
        try:
            known.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            known.append(f"{name} absent")
    return ", ".join(known)
