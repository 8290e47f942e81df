import itertools

import pytest

from cable_tracker.benchmark import round_robin
from cable_tracker.benchmark.round_robin import (
    FEWEST_ROUNDS,
    WARM_UP_CALLS,
    YARDSTICK_CALLS,
    BenchmarkCase,
    CaseLabel,
    Effort,
    measure_in_turns,
    timed_block,
)

pytestmark = pytest.mark.slow

SIZE = (320, 240)


def case(step, particles=None, name="case"):
    return BenchmarkCase(CaseLabel("frame", name, SIZE, particles=particles), lambda: step)


def busy(count):
    return lambda: sum(range(count))


def test_all_take_turns_beside_the_yardstick():
    calls = []
    cases = [case(lambda name=name: calls.append(name), name=name) for name in "ab"]
    effort = Effort(rounds=3, block=0.0)
    measured = measure_in_turns(cases, lambda: calls.append("y"), effort)
    turns = "".join(calls)[3 * WARM_UP_CALLS :]
    assert turns == "yyyyyayyyyyb" * 3
    assert [m.label.name for m in measured] == ["a", "b"]
    assert all(m.ratio.count == 3 and m.cpu.count == m.wall.count == 3 for m in measured)


class Clock:
    """Stands for the module `time`: it goes on only when something works."""

    def __init__(self):
        self.now = 1000.0

    def process_time(self):
        return self.now

    def perf_counter(self):
        return 2.0 * self.now

    def work(self, seconds):
        self.now += seconds


def test_the_ratio_is_that_of_the_times_and_milliseconds_are_given(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(round_robin, "time", clock)
    (measured,) = measure_in_turns(
        [case(lambda: clock.work(0.003))], lambda: clock.work(0.001), Effort(rounds=5)
    )
    assert measured.ratio.median == pytest.approx(3.0)
    assert measured.cpu.median == pytest.approx(3.0)
    assert measured.wall.median == pytest.approx(6.0)


def test_a_neighbour_that_slows_both_does_not_change_the_ratio(monkeypatch):
    clock = Clock()
    # A slow spell covers a block of the yardstick and the block beside it.
    spells = itertools.cycle([1.0] * (YARDSTICK_CALLS + 1) + [7.0] * (YARDSTICK_CALLS + 1))
    slowness = itertools.chain([1.0] * 2 * WARM_UP_CALLS, spells)
    monkeypatch.setattr(round_robin, "time", clock)
    (measured,) = measure_in_turns(
        [case(lambda: clock.work(0.030 * next(slowness)))],
        lambda: clock.work(0.010 * next(slowness)),
        Effort(rounds=10, block=0.0),
    )
    assert measured.ratio.median == pytest.approx(3.0)
    assert measured.cpu.high > 2.0 * measured.cpu.low


def test_progress_is_told_of_every_turn_also_of_what_is_left_out():
    told = []
    effort = Effort(rounds=4, longest=1e-9)
    measured = measure_in_turns([case(busy(10)), case(busy(10))], busy(1), effort, told.append)
    assert sum(told) == 8
    assert all(m.cpu is None and m.skipped.startswith("left out") for m in measured)


def test_what_would_take_too_long_by_what_fewer_particles_took_is_not_even_prepared():
    prepared = []

    def prepare():
        prepared.append(None)
        return busy(100_000)

    cases = [BenchmarkCase(CaseLabel("frame", "x", SIZE, n), prepare) for n in (1, 10**9)]
    first, second = measure_in_turns(cases, busy(10), Effort(rounds=1))
    assert first.cpu is not None
    assert second.skipped.startswith("left out: about")
    assert len(prepared) == 1


def test_a_used_up_budget_ends_the_turns_but_not_before_the_third():
    (measured,) = measure_in_turns([case(busy(1000))], busy(10), Effort(rounds=9, budget=0.0))
    assert measured.ratio.count == FEWEST_ROUNDS


def test_a_block_times_each_call():
    cpu, wall = timed_block(busy(10_000), 4)
    assert len(cpu) == len(wall) == 4
    assert min(cpu) > 0.0
    assert min(wall) > 0.0


def test_an_error_of_a_subject_is_not_swallowed():
    def fail():
        raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        measure_in_turns([case(fail)], busy(10), Effort())
