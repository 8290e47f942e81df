import json
import sys
from dataclasses import replace
from functools import partial

import pytest

from cable_tracker.benchmark.node_timing import NodeTiming
from cable_tracker.benchmark.plan import QUICK
from cable_tracker.benchmark.round_robin import SECTIONS, Effort
from cable_tracker.benchmark.statistics import Percentiles
from cable_tracker.commands.dev import bench

pytestmark = pytest.mark.slow

TINY = replace(
    QUICK,
    frames=6,
    sizes=((320, 240), (640, 480)),
    particles=(50, 500),
    effort=Effort(rounds=3, block=0.0),
    profiled=2,
    memory=0,
)


@pytest.fixture
def run(command, monkeypatch):
    """Run a tiny benchmark in an empty folder."""
    monkeypatch.setattr(bench, "PLANS", {False: TINY, True: TINY})
    return partial(command, "dev", "bench")


def test_a_bench_writes_numbers_tables_and_a_page(run, tmp_path):
    result = run("--output", "out.json", "--markdown", "page.md", "--memory", 50)
    assert result.code == 0, result.err
    content = json.loads((tmp_path / "out.json").read_text())
    assert list(content) == [
        "format", "circumstances", "measurements", "accuracies", "growths", "profile", "memory",
        "nodes", "starts", "contours",
    ]  # fmt: skip
    assert {each["label"]["section"] for each in content["measurements"]} == set(SECTIONS)
    for each in content["measurements"]:
        assert bool(each["skipped"]) is (each["cpu"] is None)
        if each["cpu"]:
            assert 0.0 < each["cpu"]["low"] <= each["cpu"]["median"] <= each["cpu"]["high"]
            assert each["ratio"]["count"] == 3
    (own,) = [e for e in content["measurements"] if e["label"]["section"] == "yardstick"]
    assert own["label"]["particles"] == 500
    assert {use["name"] for use in content["memory"]} == {"default", "thesis"}
    assert {each["variable"] for each in content["growths"]} == {
        "particle",
        "image pixel",
        "sample point",
    }
    assert content["nodes"] == []
    assert "Goals" in result.out
    assert "Whole frames" in result.out
    assert "## Resident memory" in (tmp_path / "page.md").read_text()
    assert {path.name for path in tmp_path.iterdir()} == {"out.json", "page.md"}


def test_an_earlier_benchmark_is_replaced_only_with_force(run, tmp_path):
    earlier = tmp_path / "bench.json"
    earlier.write_text('{"format": "cable_tracker benchmark 1"}')
    run().assert_refused("exists already")
    assert run("--quick", "--force").code == 0
    assert len(earlier.read_text()) > 1000


def test_from_node_to_node_if_asked_for(run, tmp_path, monkeypatch):
    tail = Percentiles(3.0, 4.0, 6.0, 10)
    node = NodeTiming("thesis", (640, 480), 500, 30.0, tail, None, tail, tail, 2, 0.125, 0.05)
    asked = []

    def measure_nodes(plan, frames):
        asked.append((plan, frames))
        return (node,)

    monkeypatch.setattr(bench, "need_ros", lambda _name: None)
    monkeypatch.setattr(bench, "measure_nodes", measure_nodes)
    result = run("--dds", "--dds-frames", 12, "--markdown", "page.md")
    assert result.code == 0, result.err
    assert asked == [(TINY, 12)]
    (written,) = json.loads((tmp_path / "bench.json").read_text())["nodes"]
    assert (written["cpu_share"], written["centreline"]) == (0.125, None)
    assert (
        "| thesis | 500 | 640x480 at 30 Hz | 3 / 4 / 6 | – |" in (tmp_path / "page.md").read_text()
    )


def test_without_ros_the_bench_names_the_way_to_get_it(run, tmp_path, monkeypatch):
    monkeypatch.delitem(sys.modules, "cable_tracker.ros.rigs.node_latency", raising=False)
    monkeypatch.setitem(sys.modules, "rclpy", None)
    run("--dds").assert_refused("pip install '.[ros]'")
    assert not any(tmp_path.iterdir())


def test_another_file_is_never_replaced(run, tmp_path):
    (tmp_path / "bench.json").write_text("dear")
    run("--force").assert_refused("bench.json: is no earlier output")
    assert (tmp_path / "bench.json").read_text() == "dear"


def test_a_page_without_a_place_is_refused_before_anything_is_measured(run, tmp_path):
    (tmp_path / "page.md").write_text("dear")
    run("--markdown", "page.md").assert_refused("page.md: has no place for the tables")
    assert [path.name for path in tmp_path.iterdir()] == ["page.md"]


def test_too_few_frames_for_memory_are_refused_and_nothing_is_left(run, tmp_path):
    run("--memory", 3).assert_refused("memory is 3: give 0, or at least 50")
    assert not any(tmp_path.iterdir())
