from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.evidence_correction import CorrectionRules, corrected_weights

RULES = CorrectionRules(evidence_of_bottom=1.0, evidence_limit=8.0, evidence_repeated=0.15)


def evidence_after(evidence, survived=0.0, penalty=0.0, rules=RULES) -> float:
    """Return what counts of the evidence for one group of two particles, by the correction."""
    log_prior = np.log([0.3, 0.2])
    posterior = log_prior + evidence
    full = np.ones(2)
    corrected = corrected_weights(
        posterior, log_prior, full, survived * full, np.full(2, penalty), np.zeros(2, np.int64), 1,
        rules,
    )  # fmt: skip
    changes = corrected - log_prior
    assert changes[0] == pytest.approx(changes[1])
    return changes[0]


def test_what_any_bottom_explains_is_taken_off():
    assert evidence_after(3.0) == pytest.approx(2.0)


def test_it_counts_up_to_the_limit_which_a_wrong_width_lowers():
    assert evidence_after(100.0) == pytest.approx(8.0)
    assert evidence_after(100.0, penalty=-3.0) == pytest.approx(5.0)


def test_what_survived_counts_once_more_only_by_a_share():
    assert evidence_after(3.0, survived=1.0) == pytest.approx(2.0 * 0.15)
    assert evidence_after(3.0, survived=0.5) == pytest.approx(2.0 * (0.5 * 0.15 + 0.5))


def test_within_a_group_the_likelihood_decides_as_before():
    posterior, log_prior = np.array([1.0, -1.0, 5.0]), np.zeros(3)
    ones = np.ones(3)
    corrected = corrected_weights(
        posterior, log_prior, ones, 0 * ones, 0 * ones, np.array([0, 0, -1]), 1, RULES
    )
    assert corrected[0] - corrected[1] == pytest.approx(2.0)


def test_what_is_impossible_stays_so():
    impossible = np.full(2, -math.inf)
    ones = np.ones(2)
    corrected = corrected_weights(
        impossible, impossible, ones, ones, 0 * ones, np.zeros(2, np.int64), 1, RULES
    )
    assert (corrected == -math.inf).all()
