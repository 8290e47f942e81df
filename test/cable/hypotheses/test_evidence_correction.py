from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.evidence_correction import CorrectionRules, corrected_weights

RULES = CorrectionRules(evidence_limit=8.0, evidence_repeated=0.15, thin_width=12.0)


def evidence_after(evidence, survived=0.0, penalty=0.0, width=30.0, background=0.0) -> float:
    """Return what counts of the evidence for one group of two particles, by the correction."""
    log_prior = np.log([0.3, 0.2])
    posterior = log_prior + evidence
    full = np.ones(2)
    corrected = corrected_weights(
        posterior, log_prior, full, survived * full, np.full(2, penalty), np.full(2, width),
        np.zeros(2, np.int64), 1, np.full(1, background), RULES,
    )  # fmt: skip
    changes = corrected - log_prior
    assert changes[0] == pytest.approx(changes[1])
    return changes[0]


def test_a_new_group_is_paid_for_what_it_explains():
    assert evidence_after(3.0) == pytest.approx(3.0)
    assert evidence_after(-3.0) == pytest.approx(-3.0)


def test_a_new_group_is_paid_only_for_what_it_explains_better_than_one_that_goes_on():
    log_prior = np.log([0.9, 0.1])
    for old, new in ((5.0, 7.0), (7.0, 5.0), (0.0, 99.0)):
        corrected = corrected_weights(
            log_prior + np.array([old, new]), log_prior, np.ones(2), np.array([1.0, 0.0]),
            np.zeros(2), np.full(2, 30.0), np.array([0, 1]), 2, np.zeros(2), RULES,
        )  # fmt: skip
        first, second = corrected - log_prior
        assert first == pytest.approx(0.15 * min(old, 8.0))
        assert second == pytest.approx(0.15 * old + min(new - old, 8.0))


def test_what_the_bottom_explains_as_well_is_not_paid_for():
    assert evidence_after(6.0, background=4.0) == pytest.approx(2.0)


def test_evidence_for_thin_strips_counts_less():
    assert evidence_after(4.0, width=3.0) == pytest.approx(2.0)
    assert evidence_after(4.0, width=12.0) == pytest.approx(4.0)


def test_it_counts_up_to_the_limit_which_a_wrong_width_lowers():
    assert evidence_after(100.0) == pytest.approx(8.0)
    assert evidence_after(100.0, penalty=-3.0) == pytest.approx(5.0)


def test_what_survived_counts_once_more_only_by_a_share():
    assert evidence_after(3.0, survived=1.0) == pytest.approx(3.0 * 0.15)
    assert evidence_after(3.0, survived=0.5) == pytest.approx(3.0 * (0.5 * 0.15 + 0.5))


def test_within_a_group_the_likelihood_decides_as_before():
    posterior, log_prior = np.array([1.0, -1.0, 5.0]), np.zeros(3)
    ones = np.ones(3)
    corrected = corrected_weights(
        posterior,
        log_prior,
        ones,
        0 * ones,
        0 * ones,
        30 * ones,
        np.array([0, 0, -1]),
        1,
        np.zeros(1),
        RULES,
    )
    assert corrected[0] - corrected[1] == pytest.approx(2.0)


def test_what_is_impossible_stays_so():
    impossible = np.full(2, -math.inf)
    ones = np.ones(2)
    corrected = corrected_weights(
        impossible,
        impossible,
        ones,
        ones,
        0 * ones,
        30 * ones,
        np.zeros(2, np.int64),
        1,
        np.zeros(1),
        RULES,
    )
    assert (corrected == -math.inf).all()
