"""A small fixed part of the evaluation against the distribution of recorded values.

Run this file to record the values anew, after a change that is meant to move them:
`python test/evaluation/test_regression.py`. On another processor the last bit of a sum differs, and
a filter turns it into other samples, as another seed does. So no value is compared with a value:
the figures of several seeds are compared with those of other seeds that were recorded.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from cable_tracker.evaluation.evaluation_sequences import ScenarioSequence
from cable_tracker.evaluation.methods import METHODS
from cable_tracker.evaluation.runs import MethodRun, Start, run_together

RECORDED = Path(__file__).with_name("regression.json")
FRAMES = 80
SCENARIOS = ("S3", "S5")
NAMES = ("default", "thesis")
RECORDED_SEEDS = range(12)
SEEDS = range(100, 106)
# Below them a difference means nothing: lost and silence in percent, d and w in px, alpha in deg.
SMALLEST = {"lost": 2.5, "silence": 2.5, "rmse_d": 0.1, "rmse_alpha": 0.1, "rmse_w": 0.2}
MOST_WORSE = 0.97
"""Of the pairs of a new and a recorded value. Where nothing has changed, 6 and 12 values reach it
in 4 of 18564 orders that are equally likely, whatever their distribution."""

Values = dict[str, list[float]]


def run(scenario: str, seeds: range) -> Values:
    """Return the figures of every method over the seeds of its random numbers."""
    runs = [
        MethodRun(name, METHODS[name].make, seed, Start.TRUTH) for name in NAMES for seed in seeds
    ]
    results = run_together(runs, ScenarioSequence(scenario, FRAMES).frames(0), scenario)
    return {
        f"{scenario} {method} {figure}": [
            result.metrics[figure] for result in results if result.method == method
        ]
        for method in NAMES
        for figure in SMALLEST
    }


def share_of_worse(values: list[float], recorded: list[float], smallest: float) -> float:
    """Return in how many pairs of a value and a recorded one the value is worse; NaN is."""
    pairs = np.subtract.outer(np.array(values), np.array(recorded))
    return float(np.mean(~(pairs <= smallest)))


@pytest.mark.slow
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_nothing_got_worse_than_recorded(scenario):
    recorded = json.loads(RECORDED.read_text())
    worse = [
        f"{row}: {np.round(sorted(values), 3)} > {recorded[row]}"
        for row, values in run(scenario, SEEDS).items()
        if share_of_worse(values, recorded[row], SMALLEST[row.split()[-1]]) >= MOST_WORSE
    ]
    assert not worse


@pytest.mark.parametrize("figure", SMALLEST)
def test_a_method_that_got_worse_by_its_whole_spread_would_be_told(figure):
    recorded = json.loads(RECORDED.read_text())
    for row in (name for name in recorded if name.endswith(f" {figure}")):
        every_second = np.array(recorded[row][::2])
        later = list(every_second + SMALLEST[figure] * 1.01 + np.ptp(recorded[row]))
        assert share_of_worse(list(every_second), recorded[row], 0.0) < MOST_WORSE
        assert share_of_worse(later, recorded[row], SMALLEST[figure]) >= MOST_WORSE


def test_a_figure_that_is_no_number_counts_as_worse():
    assert share_of_worse([float("nan")] * 3, [1.0, 2.0], 0.5) == 1.0


def record() -> None:
    """Write the figures of many seeds, sorted: seeds have no meaning across processors."""
    table = {
        row: [round(value, 3) for value in sorted(values)]
        for scenario in SCENARIOS
        for row, values in run(scenario, RECORDED_SEEDS).items()
    }
    lines = (f' "{row}": {json.dumps(values)}' for row, values in table.items())
    RECORDED.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    record()
