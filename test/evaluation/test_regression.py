"""A small fixed part of the evaluation against recorded values.

Run this file to record the values anew, after a change that is meant to move them:
`python test/evaluation/test_regression.py`. The value is the median over several seeds of the
method's random numbers on the same frames, and the margin reaches to the worst of them and half as
far again: other libraries round otherwise, which is like another seed.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from cable_tracker.evaluation.judged_sequences import ScenarioSequence
from cable_tracker.evaluation.methods import METHODS
from cable_tracker.evaluation.metric_table import METRICS_BY_NAME
from cable_tracker.evaluation.runs import MethodRun, RunResult, Start, run_together

RECORDED = Path(__file__).with_name("regression.json")
FRAMES = 80
SCENARIOS = ("S3", "S5")
NAMES = ("default", "thesis")
RECORDING_SEEDS = range(8)
# Smallest margins: below them a difference means nothing.
MARGINS = {"lost": 2.5, "silence": 2.5, "rmse_d": 0.3, "rmse_alpha": 0.2, "rmse_w": 0.5}


def run(scenario: str, method_seeds: tuple[int, ...]) -> list[RunResult]:
    runs = [
        MethodRun(name, METHODS[name].make, seed, Start.TRUTH)
        for name in NAMES
        for seed in method_seeds
    ]
    return run_together(runs, ScenarioSequence(scenario, FRAMES).frames(0), scenario)


def values(result: RunResult) -> dict[str, float]:
    return {name: METRICS_BY_NAME[name].read(result.metrics) for name in MARGINS}


@pytest.fixture(scope="module", params=SCENARIOS)
def results(request):
    return run(request.param, (0,))


def test_nothing_got_worse_than_recorded(results):
    recorded = json.loads(RECORDED.read_text())
    worse = [
        f"{result.sequence} {result.method} {name}: {value:.3g} > {limits['value']:.3g}"
        f" + {limits['margin']:.3g}"
        for result in results
        for name, value in values(result).items()
        if (limits := recorded[f"{result.sequence} {result.method} {name}"])
        and not value <= limits["value"] + limits["margin"]
    ]
    assert not worse


def record() -> None:
    table = {}
    for scenario in SCENARIOS:
        results = run(scenario, tuple(RECORDING_SEEDS))
        for method in NAMES:
            seen = [values(result) for result in results if result.method == method]
            for name, smallest in MARGINS.items():
                numbers = [each[name] for each in seen]
                median = float(np.median(numbers))
                margin = max(smallest, 1.5 * (max(numbers) - median))
                table[f"{scenario} {method} {name}"] = {
                    "value": round(median, 3),
                    "margin": round(margin, 3),
                }
    RECORDED.write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    record()
