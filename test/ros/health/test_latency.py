from __future__ import annotations

from itertools import pairwise

import pytest

from cable_tracker.ros.health.latency import EDGES, LATENCIES_KEPT, LatencyStatistics


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
