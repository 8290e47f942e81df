from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.particle_filter.existence import (
    PredictedExistence,
    predict_existence,
    update_existence,
)

SHARES = st.floats(0.001, 0.999)
LEAST, MOST = 1e-6, 1.0 - 1e-6


def test_the_prediction_adds_survival_and_birth():
    predicted = predict_existence(0.8, 0.9, 0.1)
    assert predicted.survived == pytest.approx(0.72)
    assert predicted.born == pytest.approx(0.02)
    assert predicted.total == pytest.approx(0.74)


@given(SHARES, SHARES, SHARES)
def test_a_prediction_is_a_probability(probability, survival, birth):
    predicted = predict_existence(probability, survival, birth)
    assert 0.0 <= predicted.total <= 1.0


@given(SHARES, SHARES, st.floats(-8.0, 8.0))
def test_an_observation_counts_by_bayes_rule(survived, birth, log_ratio):
    predicted = PredictedExistence(survived, (1.0 - survived) * birth)
    ratio = math.exp(log_ratio)
    # The evidence is averaged over a density whose mass is that of the prediction.
    mass = ratio * predicted.total
    expected = mass / (mass + 1.0 - predicted.total)
    updated = update_existence(predicted, math.log(mass), LEAST, MOST)
    assert updated == pytest.approx(min(max(expected, LEAST), MOST), rel=1e-9)


@given(SHARES)
def test_an_uninformative_observation_changes_nothing(probability):
    predicted = PredictedExistence(probability, 0.0)
    updated = update_existence(predicted, math.log(probability), LEAST, MOST)
    assert updated == pytest.approx(probability)


@pytest.mark.parametrize(
    ("log_evidence", "expected"),
    [(-math.inf, LEAST), (math.inf, MOST), (-1e6, LEAST), (1e6, MOST)],
)
def test_existence_stays_between_its_limits(log_evidence, expected):
    predicted = PredictedExistence(0.5, 0.1)
    assert update_existence(predicted, log_evidence, LEAST, MOST) == expected


@pytest.mark.parametrize("log_evidence", [-1.0, 1.0, math.inf])
def test_a_certain_existence_stays_certain(log_evidence):
    assert update_existence(PredictedExistence(1.0, 0.0), log_evidence, LEAST, MOST) == MOST
