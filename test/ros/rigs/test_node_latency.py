from __future__ import annotations

import os
import time
from collections.abc import Iterator

import pytest

from cable_tracker.benchmark.footage import Footage, footage
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.errors import RosError
from cable_tracker.ros.rigs import node_latency
from cable_tracker.ros.rigs.node_latency import NodeTrial, cpu_seconds, measure_node

FRAMES = 6


@pytest.fixture(scope="module")
def shown() -> Iterator[Footage]:
    yield footage(4, (320, 240))


@pytest.mark.slow
def test_a_few_frames_through_both_nodes_and_through_none(
    shown: Footage, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[int] = []
    # The last frame of a block is the newest, which a node always takes, when it gets to it.
    monkeypatch.setattr(node_latency, "ANSWER_TIMEOUT", 300.0)
    parameters = preset("thesis").replaced({"particle_count": 50})
    timing = measure_node(NodeTrial("thesis", parameters, shown, FRAMES), told.append)
    assert (timing.name, timing.size, timing.particles) == ("thesis", (320, 240), 50)
    assert timing.state is not None
    # A busy machine may drop a frame: the node takes the newest only.
    assert timing.state.count + timing.unanswered == FRAMES
    assert timing.echo.count <= FRAMES
    assert 1 <= timing.in_process.count <= FRAMES
    assert 0.0 < timing.echo.median <= timing.echo.p99
    assert timing.cpu_share >= 0.0
    assert sum(told) == 3 * (FRAMES + node_latency.WARM_UP)


@pytest.mark.slow
def test_a_node_that_dies_ends_the_measurement_with_its_output(
    shown: Footage, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(node_latency, "format_initial_state", lambda state: "nonsense")
    with pytest.raises(RosError, match=r"the tracker node has died: error: .*initial state"):
        measure_node(NodeTrial("thesis", preset("thesis"), shown, FRAMES), lambda count: None)


def test_work_is_seen_in_the_time_of_the_processor() -> None:
    before, end = cpu_seconds(os.getpid()), time.process_time() + 0.1
    while time.process_time() < end:
        pass
    assert cpu_seconds(os.getpid()) - before > 0.05
