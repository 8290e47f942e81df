import json

from cable_tracker.benchmark.result import BenchmarkResult, Circumstances, is_benchmark, to_json
from cable_tracker.benchmark.round_robin import CaseLabel, Measurement
from cable_tracker.benchmark.statistics import Quartiles

LABEL = CaseLabel("frame", "thesis", (320, 240), 500)
SPREAD = Quartiles(1.0, 2.0, 3.0, 4)
RESULT = BenchmarkResult(
    Circumstances("bench", "today", "here", "1", (0.0, 0.1, 0.2), (0.3, 0.4, 0.5), ("particles",)),
    (
        Measurement(LABEL, SPREAD, SPREAD, SPREAD),
        Measurement(CaseLabel("method", "lsd", (320, 240)), skipped="left out"),
    ),
    (), (), (), (),
)  # fmt: skip


def test_json_holds_all_numbers_and_names_its_kind(tmp_path):
    path = tmp_path / "bench.json"
    path.write_text(to_json(RESULT))
    content = json.loads(path.read_text())
    assert content["format"] == "cable_tracker benchmark 1"
    first, second = content["measurements"]
    assert first["label"]["particles"] == 500
    assert first["cpu"] == {"low": 1.0, "median": 2.0, "high": 3.0, "count": 4}
    assert (second["cpu"], second["skipped"]) == (None, "left out")
    assert is_benchmark(path)


def test_other_files_are_no_benchmark(tmp_path):
    for number, text in enumerate(("{}", "[1]", "no json", '{"format": "other"}')):
        path = tmp_path / str(number)
        path.write_text(text)
        assert not is_benchmark(path)
    assert not is_benchmark(tmp_path)
    assert not is_benchmark(tmp_path / "missing")


def test_what_was_left_out_is_not_found():
    assert RESULT.find(LABEL) is RESULT.measurements[0]
    assert RESULT.find(RESULT.measurements[1].label) is None
    assert RESULT.of("method") == [RESULT.measurements[1]]
