import pytest

from cable_tracker.benchmark.accuracy import measure_accuracy
from cable_tracker.benchmark.library_filters import LIBRARY_LOOPS, is_installed
from cable_tracker.evaluation.methods import METHODS


@pytest.mark.slow
def test_all_that_is_timed_is_judged_and_both_presets_hold_the_cable():
    accuracies = {each.name: each for each in measure_accuracy(10)}
    assert set(accuracies) == {*METHODS, *filter(is_installed, LIBRARY_LOOPS)}
    for name in ("default", "thesis"):
        assert accuracies[name].lost == 0.0
        assert 0.0 < accuracies[name].rmse_d < 8.0
