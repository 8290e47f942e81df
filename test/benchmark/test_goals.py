import math

import pytest

from cable_tracker.benchmark.cases import Accuracy
from cable_tracker.benchmark.fresh_processes import MemoryUse
from cable_tracker.benchmark.goals import Goal, goals_of
from cable_tracker.benchmark.node_timing import NodeTiming
from cable_tracker.benchmark.result import BenchmarkResult, Circumstances
from cable_tracker.benchmark.round_robin import CaseLabel, Measurement
from cable_tracker.benchmark.statistics import Percentiles, Quartiles

CIRCUMSTANCES = Circumstances("", "", "", "", (0.0,) * 3, (0.0,) * 3, ())
SIZE = (320, 240)


def timed(ratio, *label):
    spread = Quartiles(ratio, ratio, ratio, 1)
    return Measurement(CaseLabel(*label), spread, spread, spread)


def result_of(*measurements, accuracies=(), memory=(), nodes=()):
    return BenchmarkResult(CIRCUMSTANCES, measurements, accuracies, (), (), memory, nodes)


def goal(result, words):
    (found,) = [each for each in goals_of(result) if words in each.text]
    return found


@pytest.mark.parametrize(
    ("at_least", "measured", "verdict"),
    [
        (False, 1.0, "yes"),
        (False, 1.1, "no"),
        (True, 1.0, "yes"),
        (True, 0.9, "no"),
        (True, None, "not measured"),
        (False, math.nan, "not measured"),
    ],
)
def test_a_goal_is_met_or_not(at_least, measured, verdict):
    assert Goal("", 1.0, at_least, measured).verdict == verdict


def test_nothing_measured_meets_no_goal():
    assert {each.verdict for each in goals_of(result_of())} == {"not measured"}


def test_ratios_to_the_yardstick_and_to_libraries():
    result = result_of(
        timed(0.1, "frame", "thesis", SIZE, 500),
        timed(9.0, "frame", "default", SIZE, 10_000),
        timed(0.7, "library", "filterpy", SIZE, 500),
    )
    assert goal(result, "`thesis`, 320x240, over the yardstick").measured == 0.1
    assert goal(result, "10 000 particles, over").verdict == "no"
    assert goal(result, "filterpy").measured == pytest.approx(7.0)
    assert goal(result, "on particles").measured is None


def test_only_baselines_that_are_as_good_count():
    result = result_of(
        timed(2.0, "frame", "default", SIZE, 500),
        timed(1.0, "method", "texture", SIZE),
        timed(4.0, "method", "hough", SIZE),
        accuracies=(
            Accuracy("default", 1.0, 0.5, 0.5),
            Accuracy("texture", 30.0, 0.1, 0.1),
            Accuracy("hough", 1.0, 3.0, 3.0),
        ),
    )
    assert goal(result, "`default` over the fastest baseline").measured == pytest.approx(0.5)


def test_latency_of_the_node_and_growth_of_memory_are_held_against_goals():
    tail = Percentiles(3.0, 4.0, 6.0, 10)
    alone = Percentiles(2.0, 2.0, 2.5, 10)
    node = NodeTiming("thesis", (640, 480), 500, 30.0, tail, tail, alone, alone, 0, 0.1, 0.05)
    use = MemoryUse("default", 1000, 100.0, 0.1, 2.0)
    result = result_of(memory=(use,), nodes=(node,))
    assert (
        goal(result, "`thesis`, 640x480 at 30 Hz: latency added by node and DDS, median").measured
        == 1.0
    )
    assert (
        goal(result, "`thesis`, 640x480 at 30 Hz: latency added by node and DDS, 99").measured
        == 3.5
    )
    assert goal(result, "memory").verdict == "yes"


@pytest.mark.parametrize(("answered", "unanswered"), [(0, 10), (94, 6)])
def test_a_node_that_is_too_slow_for_the_rate_meets_no_latency(answered, unanswered):
    alone = Percentiles(2.0, 2.0, 2.5, 10)
    state = Percentiles(1.0, 1.0, 1.0, answered) if answered else None
    node = NodeTiming(
        "thesis", (640, 480), 500, 30.0, state, None, alone, alone, unanswered, 0.1, 0.05
    )
    words = "`thesis`, 640x480 at 30 Hz: latency added by node and DDS, median"
    assert goal(result_of(nodes=(node,)), words).verdict == "no"
