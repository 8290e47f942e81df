from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

from cable_tracker.evaluation.sample_statistics import (
    mean,
    median,
    percentage,
    percentages,
    percentile_of_size,
    root_mean_square,
    spread_of,
)


def test_figures_of_a_sample_are_those_worked_out_by_hand():
    values = np.array([-3.0, 4.0, 0.0, 0.0])
    assert mean(values) == pytest.approx(0.25)
    assert mean([True, False, True, True]) == pytest.approx(0.75)
    assert median([1.0, 9.0, 2.0]) == 2.0
    assert root_mean_square(values) == pytest.approx(2.5)
    assert percentile_of_size(values, 100.0) == 4.0
    assert percentage(1, 8) == 12.5
    assert percentages(np.array([1.0, 0.0]), np.array([4.0, 2.0])).tolist() == [25.0, 0.0]


def test_an_empty_sample_has_no_figure_and_warns_of_nothing():
    none = np.empty(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = [mean([]), median(none), root_mean_square(none), percentile_of_size(none, 95.0)]
        found += [percentage(0, 0), *percentages(np.zeros(2), np.zeros(2))]
    assert all(math.isnan(each) for each in found)


def test_spread_by_hand():
    spread = spread_of([1.0, 2.0, math.nan, 6.0])
    assert (spread.count, spread.mean, spread.median) == (3, 3.0, 2.0)
    assert (spread.minimum, spread.maximum) == (1.0, 6.0)
    assert spread.standard_error == pytest.approx(math.sqrt(7.0 / 3.0))  # variance 14 / 2


def test_one_run_has_no_standard_error():
    assert math.isnan(spread_of([4.0]).standard_error)


def test_an_infinite_number_stays_infinite():
    assert spread_of([1.0, math.inf]).mean == math.inf


def test_nothing_is_unknown():
    spread = spread_of([math.nan])
    assert spread.count == 0
    assert math.isnan(spread.mean)
