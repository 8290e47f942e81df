"""Linear fits of the time of a frame over particles, pixels and sample points."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from cable_tracker.benchmark.cases import REFERENCE_PARTICLES
from cable_tracker.benchmark.footage import RENDERED_SIZE
from cable_tracker.benchmark.round_robin import CaseLabel, Measurement
from cable_tracker.benchmark.statistics import fit_line

NANOSECONDS_PER_MS = 1e6


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
