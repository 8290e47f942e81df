import math

import numpy as np
import pytest

from cable_tracker.cable.model.state import CableState
from cable_tracker.evaluation.consistency import (
    coverage,
    nees,
    sigma_factors,
)
from cable_tracker.evaluation.trace import trace_of


def test_nees_by_hand():
    covariance = np.array([[4.0, 1.0], [1.0, 1.0]])
    # Inverse: [[1, -1], [-1, 4]] / 3.
    squares = nees(np.array([[1.0, 1.0], [0.0, 0.0]]), np.stack((covariance, covariance)))
    assert squares == pytest.approx([1.0, 0.0])


def test_nees_of_a_singular_covariance_is_infinite():
    assert nees(np.ones((2, 2)), np.stack((np.ones((2, 2)), np.zeros((2, 2))))).tolist() == [
        math.inf,
        math.inf,
    ]


def test_nees_of_honest_errors_is_their_number_of_dimensions():
    rng = np.random.default_rng(0)
    factor = np.array([[3.0, 0, 0, 0], [0.01, 0.02, 0, 0], [1, 0, 2, 0], [0, 0, 0.004, 0.01]])
    errors = rng.standard_normal((4000, 4)) @ factor.T
    squares = nees(errors, np.tile(factor @ factor.T, (4000, 1, 1)))
    assert squares.mean() == pytest.approx(4.0, rel=0.05)
    assert np.median(squares) == pytest.approx(3.357, rel=0.05)


def test_coverage_of_honest_errors_is_nominal(outcome):
    rng = np.random.default_rng(1)
    sigma = np.array((2.0, 0.02, 3.0, 0.01))
    truth = CableState(0.0, 0.0, 60.0)
    outcomes = [outcome(i, truth, tuple(rng.standard_normal(4) * sigma)) for i in range(1500)]
    nominal = np.array([0.2, 0.5, 0.9])
    shares = coverage([trace_of(outcomes)], nominal)
    assert shares == pytest.approx(np.tile(nominal[:, None], (1, 4)), abs=0.04)


def test_coverage_of_nothing_is_unknown(trace):
    assert np.isnan(coverage([trace("ss")], np.array([0.5]))).all()


def test_factors_bring_sigma_to_the_errors(outcome):
    rng = np.random.default_rng(2)
    stated = np.array((2.0, 0.02, 3.0, 0.01))
    wanted = np.array((0.5, 1.0, 2.0, 3.0))
    truth = CableState(0.0, 0.0, 60.0)
    errors = rng.standard_normal((3000, 4)) * stated * wanted
    runs = [
        trace_of(
            [outcome(i, truth, tuple(each), sigma=tuple(stated)) for i, each in enumerate(part)]
        )
        for part in np.split(errors, 2)
    ]
    assert sigma_factors(runs, 0.95) == pytest.approx(wanted, rel=0.06)


def test_a_factor_is_the_ratio_that_holds_so_many(outcome):
    truth = CableState(0.0, 0.0, 60.0)
    errors = [(2.0 * place, 0.0, 3.0, 0.0) for place in range(1, 5)]
    run = trace_of([outcome(i, truth, error) for i, error in enumerate(errors)])
    # Half of the ratios 1, 2, 3, 4 are held from 3 on, where 0.674 should do.
    factors = sigma_factors([run], 0.5)
    assert factors == pytest.approx([3.0 / 0.67449, 0.0, 1.0 / 0.67449, 0.0], rel=1e-4)


def test_factors_of_nothing_are_unknown(trace):
    assert np.isnan(sigma_factors([trace("ss")], 0.95)).all()
