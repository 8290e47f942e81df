import json

import pytest

from cable_tracker.benchmark.result import (
    BenchmarkResult,
    Circumstances,
    fit_growth,
    is_benchmark,
    to_json,
)
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


def measured(milliseconds, **label):
    given = {"section": "frame", "name": "thesis", "size": (320, 240)} | label
    return Measurement(CaseLabel(**given), Quartiles(milliseconds, milliseconds, milliseconds, 1))


def by_variable(measurements):
    return {growth.variable: growth for growth in fit_growth(measurements)}


def test_cost_per_particle_pixel_and_point():
    growth = by_variable(
        [
            measured(1.5, particles=500),
            measured(3.0, particles=2000),
            measured(1.5 + 640 * 480 * 1e-6 - 320 * 240 * 1e-6, particles=500, size=(640, 480)),
            measured(2.0, section="spacing", particles=500, amount=10_000.0),
            measured(3.0, section="spacing", particles=500, amount=20_000.0),
        ]
    )
    assert growth["particle"].each == pytest.approx(1000.0)
    assert growth["particle"].base == pytest.approx(1.0)
    assert growth["image pixel"].each == pytest.approx(1.0)
    assert growth["sample point"].each == pytest.approx(100.0)
    assert {each.points for each in growth.values()} == {2}


def test_one_measurement_makes_no_line():
    assert fit_growth([measured(1.0, particles=500)]) == []


def test_what_was_left_out_does_not_count():
    left_out = Measurement(CaseLabel("frame", "thesis", (320, 240), 100_000), skipped="left out")
    assert fit_growth([measured(1.0, particles=500), left_out]) == []


def test_presets_have_lines_of_their_own():
    both = [
        measured(0.001 * count * factor, particles=count, name=name)
        for name, factor in (("thesis", 1.0), ("default", 10.0))
        for count in (500, 1000)
    ]
    assert [growth.each for growth in fit_growth(both)] == pytest.approx([1000.0, 10_000.0])
