"""Accuracy of the methods that are timed, on the same frames."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

from cable_tracker.benchmark.cases import REFERENCE_PARTICLES
from cable_tracker.benchmark.footage import SEED, rendered_frames
from cable_tracker.benchmark.library_filters import LIBRARY_LOOPS, LibraryMethod, is_installed
from cable_tracker.evaluation.methods import METHODS, Method
from cable_tracker.evaluation.runs import MethodRun, Start, run_together


@dataclass(frozen=True, slots=True)
class Accuracy:
    """Accuracy of a method on the frames of the benchmark, started from the truth.

    Attributes
    ----------
    name : str
        Name of the method or library.
    lost : float
        Share of the frames in which the estimate is beside the cable [%].
    rmse_d, rmse_alpha : float
        Root mean square error of d [px] and alpha [deg].
    """

    name: str
    lost: float
    rmse_d: float
    rmse_alpha: float


def measure_accuracy(frame_count: int) -> list[Accuracy]:
    """Track the frames at 320x240 with every method and every installed library."""
    makers: dict[str, Callable[[int], Method]] = {name: spec.make for name, spec in METHODS.items()}
    for name in filter(is_installed, LIBRARY_LOOPS):
        makers[name] = functools.partial(LibraryMethod, name, REFERENCE_PARTICLES)
    runs = [MethodRun(name, make, SEED, Start.TRUTH) for name, make in makers.items()]
    results = run_together(runs, rendered_frames(frame_count), "benchmark")
    return [
        Accuracy(
            result.method,
            *(result.metrics[m] for m in ("lost", "rmse_d", "rmse_alpha")),
        )
        for result in results
    ]
