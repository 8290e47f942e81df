from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from cable_tracker.cable.model.estimate import CableEstimate, Hypothesis
from cable_tracker.cable.model.state import CableState
from cable_tracker.ros.health.diagnostics import (
    DISABLED,
    EDGES,
    FROZEN_INPUT,
    LATENCIES_KEPT,
    LEVELS,
    STALE_INPUT,
    WARMING_UP,
    WINDOW,
    FrameStatistics,
    LatencyStatistics,
    Level,
    cable_values,
    frame_values,
    make_diagnostics,
)
from cable_tracker.ros.messages.rclpy_messages import RclpyMessages
from cable_tracker.tracking.status import TrackingStatus


def test_every_status_has_a_level() -> None:
    own = {WARMING_UP, STALE_INPUT, FROZEN_INPUT, DISABLED}
    assert set(LEVELS) == {*(status.value for status in TrackingStatus), *own}


@pytest.mark.parametrize(
    ("status", "level"),
    [("TRACKING", Level.OK), ("LOST", Level.ERROR), (STALE_INPUT, Level.STALE)],
)
def test_the_level_follows_from_the_status(status: str, level: Level) -> None:
    factory = RclpyMessages()
    header = factory.make("std_msgs/msg/Header")
    message = make_diagnostics(factory, header, "/tracker", status, {"key": "value"})
    entry = message.status[0]
    assert entry.level == bytes([level])
    assert (entry.name, entry.message, entry.hardware_id) == (
        "/tracker: tracking",
        status,
        "/tracker",
    )
    assert [(pair.key, pair.value) for pair in entry.values] == [("key", "value")]


def test_the_frame_rate_counts_the_last_seconds_only() -> None:
    statistics = FrameStatistics()
    for number in range(100):
        statistics.arrivals.append(number * 0.1)
    assert statistics.frame_rate(9.9) == pytest.approx(10.0, abs=0.51)
    assert statistics.frame_rate(9.9 + 2 * WINDOW) == 0.0
    assert not statistics.arrivals


def test_figures_before_the_first_frame_are_empty_not_wrong() -> None:
    values = frame_values(FrameStatistics(), 0.0) | cable_values(None)
    for key in ("N_eff", "evidence", "presence [%]", "hypotheses", "last bad frame"):
        assert values[key] == ""
    assert values["frames tracked"] == "0"


@pytest.mark.parametrize(
    ("presence", "probabilities", "words"),
    [
        (0.984, (0.91, 0.08), ("98", "2 (91 %, 8 %)")),
        (0.0, (1.0,), ("0", "1 (100 %)")),
        (None, (), ("", "")),
    ],
)
def test_presence_and_hypotheses_are_given_in_percent(
    presence: float | None, probabilities: tuple[float, ...], words: tuple[str, str]
) -> None:
    state = CableState(1.0, 0.1, 30.0)
    estimate = CableEstimate(
        stamp=1,
        status=TrackingStatus.TRACKING,
        state=state,
        covariance=np.eye(8),
        effective_sample_size=10.0,
        evidence=2.0,
        image_size=(320, 240),
        presence=presence,
        hypotheses=tuple(Hypothesis(each, state) for each in probabilities),
    )
    values = cable_values(estimate)
    assert (values["presence [%]"], values["hypotheses"]) == words


def test_the_edges_are_spaced_evenly_on_a_logarithmic_scale() -> None:
    assert {high / low for low, high in pairwise(EDGES)} == {2.0}
    assert (EDGES[0], EDGES[-1]) == (0.5, 1024.0)


def test_every_time_falls_into_one_bin_and_one_on_an_edge_above_it() -> None:
    latency = LatencyStatistics()
    for milliseconds in (0.0, 0.49, 0.5, 0.99, 3.0, 4.0, 1023.0, 1024.0, 1e9):
        latency.add(milliseconds)
    assert len(latency.counts) == len(EDGES) + 1
    assert latency.counts == [2, 2, 0, 1, 1, 0, 0, 0, 0, 0, 0, 1, 2]


def test_percentiles_are_of_the_last_frames_and_counts_of_all() -> None:
    latency = LatencyStatistics()
    assert latency.percentiles() == (0.0, 0.0, 0.0)
    for milliseconds in range(101):
        latency.add(float(milliseconds))
    assert latency.percentiles() == pytest.approx((50.0, 95.0, 99.0))
    for _ in range(2 * LATENCIES_KEPT):
        latency.add(7.0)
    assert len(latency.latest) == LATENCIES_KEPT
    assert latency.percentiles() == (7.0, 7.0, 7.0)
    assert sum(latency.counts) == 101 + 2 * LATENCIES_KEPT


def test_the_diagnostics_can_be_read_back() -> None:
    latency = LatencyStatistics()
    latency.add(3.0)
    values = latency.as_values()
    edges = tuple(map(float, values["latency histogram edges [ms]"].split()))
    counts = list(map(int, values["latency histogram counts"].split()))
    assert (edges, counts) == (EDGES, latency.counts)
    assert values["latency median [ms]"] == "3.00"
