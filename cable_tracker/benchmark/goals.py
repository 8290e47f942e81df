"""Goals of the tracker, with the measured values."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from cable_tracker.benchmark.cases import REFERENCE_PARTICLES, TIMED_PRESETS
from cable_tracker.benchmark.footage import RENDERED_SIZE
from cable_tracker.benchmark.node_timing import NodeTiming
from cable_tracker.benchmark.result import BenchmarkResult
from cable_tracker.benchmark.round_robin import CaseLabel
from cable_tracker.benchmark.statistics import Percentiles

FULL_HD, VGA = (1920, 1080), (640, 480)
FLAT_MEMORY = 64.0
"""Growth that counts as none, of pages that the allocator retains [KiB per 1000 frames]."""


MOST_UNANSWERED = 0.05
"""A node that leaves a larger share of the frames unanswered is too slow for the rate."""


@dataclass(frozen=True, slots=True)
class Goal:
    """One goal.

    Attributes
    ----------
    text : str
        Measured quantity, in words.
    limit : float
        Limit that the quantity must keep.
    at_least : bool
        Whether the limit is a lower one.
    measured : float or None
        Measured value; None if it was not measured.
    unit : str
        Unit of limit and value; empty for ratios.
    """

    text: str
    limit: float
    at_least: bool
    measured: float | None
    unit: str = ""

    @property
    def verdict(self) -> str:
        """Yes, no, or not measured."""
        if self.measured is None or math.isnan(self.measured):
            return "not measured"
        met = self.measured >= self.limit if self.at_least else self.measured <= self.limit
        return "yes" if met else "no"


def goals_of(result: BenchmarkResult) -> list[Goal]:
    """Return all goals with their measured values."""
    return [
        *_frame_goals(result),
        *_rival_goals(result),
        *_node_goals(result),
        *_memory_goals(result),
        *_start_goals(result),
        *_contour_goals(result),
    ]


def _frame_goals(result: BenchmarkResult) -> list[Goal]:
    goals = []
    for name, limit in (("thesis", 0.4), ("default", 0.8)):
        ratio = _ratio(result, "frame", name)
        goals.append(Goal(f"`{name}`, 320x240, over the yardstick", limit, False, ratio))
    ratio = _ratio(result, "frame", "default", FULL_HD)
    goals.append(Goal("`default`, 1920x1080, over the yardstick", 1.5, False, ratio))
    ratio = _ratio(result, "frame", "default", particles=10_000)
    goals.append(Goal("`default`, 10 000 particles, over the yardstick", 6.0, False, ratio))
    return goals


def _ratio(
    result: BenchmarkResult,
    section: str,
    name: str,
    size: tuple[int, int] = RENDERED_SIZE,
    particles: int = REFERENCE_PARTICLES,
) -> float | None:
    found = result.find(CaseLabel(section, name, size, particles))
    return found.ratio.median if found is not None and found.ratio is not None else None


def _over(first: float | None, second: float | None) -> float | None:
    return first / second if first is not None and second else None


def _rival_goals(result: BenchmarkResult) -> list[Goal]:
    goals = []
    ours = {name: _ratio(result, "frame", name) for name in TIMED_PRESETS}
    for rival in ("particles", "filterpy"):
        faster = _over(_ratio(result, "library", rival), ours["thesis"])
        goals.append(Goal(f"`thesis`: the same on {rival} over ours", 5.0, True, faster))
    for name in ("thesis", "default"):
        fastest = _over(ours[name], _fastest_as_good(result, name))
        text = f"`{name}` over the fastest baseline that loses no more frames"
        goals.append(Goal(text, 1.0, False, fastest))
    return goals


def _fastest_as_good(result: BenchmarkResult, name: str) -> float | None:
    """Return the ratio of the fastest baseline that loses no more frames than a preset."""
    lost = {accuracy.name: accuracy.lost for accuracy in result.accuracies}
    ratios = [
        m.ratio.median
        for m in result.of("method")
        if m.ratio is not None and lost.get(m.label.name, math.inf) <= lost.get(name, math.inf)
    ]
    return min(ratios, default=None)


def _node_goals(result: BenchmarkResult) -> list[Goal]:
    goals = []
    for name in ("thesis", "default"):
        share = _of_nodes(result, name, VGA, 10_000, lambda node: 100 * node.cpu_share)
        text = f"`{name}`, 10 000 particles, 640x480 at 30 Hz: share of a core"
        goals.append(Goal(text, 50.0, False, share, "%"))
    for name in ("thesis", "default"):
        share = _of_nodes(
            result, name, RENDERED_SIZE, REFERENCE_PARTICLES, lambda node: 100 * node.cpu_share
        )
        text = f"`{name}`, 320x240 at 30 Hz: share of a core"
        goals.append(Goal(text, 15.0, False, share, "%"))
    for name in ("thesis", "default"):
        for words, limit, read in (
            ("median", 2.0, lambda node: _added(node, lambda tail: tail.median)),
            ("99th percentile", 5.0, lambda node: _added(node, lambda tail: tail.p99)),
        ):
            added = _of_nodes(result, name, VGA, REFERENCE_PARTICLES, read)
            text = f"`{name}`, 640x480 at 30 Hz: latency added by node and DDS, {words}"
            goals.append(Goal(text, limit, False, added, "ms"))
    return goals


def _added(node: NodeTiming, read: Callable[[Percentiles], float]) -> float | None:
    """Return the latency that the node adds [ms]; infinite where it is too slow for the rate."""
    added = node.added_latency()
    if added is None or node.unanswered > MOST_UNANSWERED * (node.unanswered + added.count):
        return math.inf
    return read(added)


def _of_nodes(
    result: BenchmarkResult,
    name: str,
    size: tuple[int, int],
    particles: int,
    read: Callable[..., float | None],
) -> float | None:
    for node in result.nodes:
        if (node.name, node.size, node.particles) == (name, size, particles):
            return read(node)
    return None


def _memory_goals(result: BenchmarkResult) -> list[Goal]:
    return [
        Goal(
            f"`{use.name}`, growth of memory over {use.frames} frames",
            FLAT_MEMORY,
            False,
            use.per_thousand,
            "KiB per 1000 frames",
        )
        for use in result.memory
    ]


def _start_goals(result: BenchmarkResult) -> list[Goal]:
    goals = []
    for each in result.starts:
        if each.name == "default":
            goals.append(Goal("`default`, first start", 20.0, False, each.cold, "s"))
            goals.append(Goal("`default`, later starts", 1.0, False, each.warm, "s"))
    return goals


def _contour_goals(result: BenchmarkResult) -> list[Goal]:
    goals = []
    for each in result.contours:
        goals.append(Goal("a contour on 320x240 from a wrong start", 0.5, False, each.ms, "ms"))
        is_fair = each.rival_overlap is not None and each.rival_overlap >= 0.98 * each.overlap
        ratio = each.ratio if is_fair else None
        goals.append(Goal("faster than scikit-image's morphological_chan_vese", 200.0, True, ratio))
    return goals
