import mmap

import pytest

from cable_tracker.benchmark import memory
from cable_tracker.benchmark.memory import KIB, measure_memory, measure_memory_apart, resident_bytes


def test_memory_that_is_used_is_seen():
    before = resident_bytes()
    # Fresh pages: what the allocator hands out may have been resident before.
    with mmap.mmap(-1, 64 * KIB**2) as held:
        held.write(b"x" * len(held))
        assert resident_bytes() - before > 50 * KIB**2


def test_frames_after_the_warm_up_are_watched(shown):
    use = measure_memory("thesis", shown, 60)
    assert use.frames == 48
    assert use.start > 10.0


@pytest.mark.slow
def test_a_fresh_process_does_the_same():
    use = measure_memory_apart("thesis", 3, 50)
    assert (use.name, use.frames) == ("thesis", 40)


def test_steady_growth_is_found(shown, monkeypatch):
    sizes = iter(range(100 * KIB**2, 10**12, KIB))
    monkeypatch.setattr(memory, "resident_bytes", lambda: next(sizes))
    use = measure_memory("thesis", shown, 50)
    assert use.start == pytest.approx(100.0)
    assert use.per_thousand == pytest.approx(1000.0, rel=0.01)
    assert use.growth > 0.0
