import mmap

import pytest

from cable_tracker.benchmark import fresh_processes
from cable_tracker.benchmark.fresh_processes import KIB, measure_memory, resident_bytes


def test_memory_that_is_used_is_seen():
    before = resident_bytes()
    # Fresh pages: what the allocator hands out may have been resident before.
    with mmap.mmap(-1, 64 * KIB**2) as held:
        held.write(b"x" * len(held))
        assert resident_bytes() - before > 50 * KIB**2


def test_steady_growth_is_found(shown, monkeypatch):
    sizes = iter(range(100 * KIB**2, 10**12, KIB))
    monkeypatch.setattr(fresh_processes, "resident_bytes", lambda: next(sizes))
    use = measure_memory("thesis", shown, 50)
    assert use.start == pytest.approx(100.0)
    assert use.per_thousand == pytest.approx(1000.0, rel=0.01)
    assert use.growth > 0.0
