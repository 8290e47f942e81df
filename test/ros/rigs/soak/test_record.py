from __future__ import annotations

import json
from collections.abc import Sequence

from cable_tracker.ros.rigs.soak.record import (
    LARGEST_GROWTH,
    MOST_BREACHES,
    WARM_UP,
    MemorySample,
    SoakRecord,
)


def record_of(sizes: Sequence[float], process: int = 1, frames: int = WARM_UP) -> SoakRecord:
    samples = [
        MemorySample(0.1 * index, frames + index, process, size, 1.0)
        for index, size in enumerate(sizes)
    ]
    return SoakRecord(memory=samples)


def test_growing_memory_breaks_the_promise():
    record = record_of([100.0 + index for index in range(50)])
    record.check_growth()
    assert record.growth() > LARGEST_GROWTH
    assert len(record.breaches) == 1


def test_growth_before_the_warm_up_does_not_count():
    record = record_of([100.0 + index for index in range(50)], frames=0)
    assert record.growth() == 0.0


def test_a_single_high_sample_is_no_growth():
    assert record_of([100.0] * 30 + [200.0] + [100.0] * 30).growth() == 0.0


def test_another_process_is_no_growth():
    record = record_of([100.0] * 30)
    record.memory += record_of([150.0] * 30, process=2).memory
    assert record.growth() == 0.0


def test_latencies_are_summarised_by_the_minute():
    record = SoakRecord(latencies=[(0.1, 10.0), (0.9, 30.0), (2.5, 7.0)])
    windows = record.latency_windows()
    assert [(w["minutes"], w["frames"], w["median"], w["longest"]) for w in windows] == [
        (0.0, 2, 20.0, 30.0),
        (2.0, 1, 7.0, 7.0),
    ]


def test_without_frames_there_are_no_latencies():
    assert SoakRecord().latency_windows() == []


def test_the_json_holds_everything():
    record = record_of([100.0] * 3)
    record.sent = 5
    record.faults["overload"] += 2
    record.latencies.append((0.0, 4.0))
    record.broken("no answer")
    content = json.loads(record.as_json({"seed": 3}))
    assert content["settings"] == {"seed": 3}
    assert content["frames_sent"] == 5
    assert content["faults"] == {"overload": 2}
    assert content["broken_promises"] == ["no answer"]
    assert content["latency"][0]["median"] == 4.0
    assert [sample["private"] for sample in content["memory"]] == [100.0] * 3


def test_a_sample_of_memory_names_the_faults_since_the_one_before():
    record = SoakRecord()
    record.inject("overload")
    record.inject("no pixels")
    for _ in range(2):
        record.add_memory(MemorySample(0.1, 1, 1, 100.0, 1.0))
    assert [sample.faults for sample in record.memory] == ["overload; no pixels", ""]
    assert record.faults == {"overload": 1, "no pixels": 1}


def test_breaches_do_not_fill_the_memory():
    record = SoakRecord()
    for _ in range(2 * MOST_BREACHES):
        record.broken("again")
    assert len(record.breaches) == MOST_BREACHES
