import math

import numpy as np
import pytest

from cable_tracker.evaluation.targets.comparison import (
    FIGURES,
    RunFigures,
    ScenarioTask,
    markdown_table,
    mean_figures,
)
from cable_tracker.evaluation.targets.peers import PEERS


def test_a_run_has_figures_for_every_method():
    counted = []
    results = ScenarioTask("buoy", 1, ("default", "CamShift", "grey default"), 12).run(
        lambda: counted.append(1)
    )
    assert [each.method for each in results] == ["default", "CamShift", "grey default"]
    assert all(each.values[FIGURES.index("claimed_in_view")] > 0.5 for each in results)
    assert results[0].values[0] > 0.8
    assert len(counted) == 12


@pytest.mark.parametrize("name", sorted(PEERS))
def test_peers_follow_an_easy_target(name):
    (result,) = ScenarioTask("near_surface", 1, (name,), 8).run(lambda: None)
    assert result.values[0] > 0.5


def test_without_a_target_there_is_nothing_to_follow():
    assert ScenarioTask("nothing", 1, ("default",), 3).run(lambda: None) == []


def test_means_pass_over_what_has_no_figure():
    nan = math.nan
    rows = [
        RunFigures("buoy", 0, "default", (1.0, 1.0, nan, nan, nan, 2.0)),
        RunFigures("leaving", 0, "default", (0.5, 1.0, 0.2, 1.0, nan, 4.0)),
    ]
    means = mean_figures(rows, "default", None)
    assert means[:4] == [0.75, 1.0, 0.2, 1.0]
    assert np.isnan(means[4])
    assert "| default | 75 | 100 | 20 | 100 |  | 3.0 |" in markdown_table(rows, ["default"], "note")
