from __future__ import annotations

import math

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.clusters import NO_CLUSTER, Groups
from cable_tracker.cable.hypotheses.evidence_correction import (
    BACKGROUND_SHARE,
    CLEAR_MAP,
    FAINT_MAP,
    ORDINARY_APPEARANCE,
    GroupEvidence,
    WeighedParticles,
    corrected_log_weights,
    reference_group,
)
from cable_tracker.cable.hypotheses.frame_inputs import frame_config
from cable_tracker.cable.hypotheses.predicted_density import empty_densities
from cable_tracker.cable.parameters.parameters import TrackerParameters

CONFIG = frame_config(TrackerParameters(), 4.0, (320, 240))._replace(
    evidence_limit=8.0, evidence_repeated=0.15, thin_width=12.0
)


def corrected(
    log_posterior,
    log_prior,
    survived,
    labels,
    penalty=0.0,
    width=30.0,
    background=0.0,
    appearance=ORDINARY_APPEARANCE,
    is_known=False,
    mapped=0.0,
):
    """Log-weights of particles of one width, of each of which a share has survived."""
    count = len(labels)
    states = np.zeros((count, 8))
    states[:, 2] = width
    densities = empty_densities(count)._replace(
        prior=np.ones(count),
        prior_survival=np.array(survived),
        width_penalties=np.full(count, penalty),
    )
    particles = WeighedParticles(
        states, log_prior, log_posterior, densities, np.full(count, mapped)
    )
    groups = Groups(np.array(labels), max(labels) + 1)
    backgrounds = np.full(groups.number, background)
    appearances = np.full(groups.number, appearance)
    config = CONFIG._replace(is_known=is_known)
    return corrected_log_weights(particles, groups, backgrounds, appearances, config)


def evidence_after(evidence, survived=0.0, **others) -> float:
    """Return what counts of the evidence for one group of two particles, by the correction."""
    log_prior = np.log([0.3, 0.2])
    after = corrected(log_prior + evidence, log_prior, [survived] * 2, [0, 0], **others)
    changes = after - log_prior
    assert changes[0] == pytest.approx(changes[1])
    return changes[0]


def test_the_share_of_the_map_in_the_evidence_is_not_counted_again_for_a_group():
    assert evidence_after(3.0, mapped=2.0) == pytest.approx(evidence_after(1.0))


@pytest.mark.parametrize(
    ("mapped", "share"),
    [
        (0.0, 1.0),
        (FAINT_MAP, 1.0),
        (0.5 * (FAINT_MAP + CLEAR_MAP), 0.5),
        (CLEAR_MAP, 0.0),
        (CLEAR_MAP + 5.0, 0.0),
    ],
)
def test_the_clearer_the_map_is_the_less_count_the_borders(mapped, share):
    above = 4.0
    assert evidence_after(mapped + above, mapped=mapped) == pytest.approx(
        share * BACKGROUND_SHARE * above
    )
    unlike = evidence_after(mapped + above, mapped=mapped, appearance=ORDINARY_APPEARANCE - 3.0)
    assert unlike == pytest.approx(share * BACKGROUND_SHARE * above - 3.0)


def test_the_evidence_of_a_new_group_counts_by_the_share_that_it_explains():
    assert evidence_after(3.0) == pytest.approx(BACKGROUND_SHARE * 3.0)
    assert evidence_after(-3.0) == pytest.approx(BACKGROUND_SHARE * -3.0)


def test_how_much_it_looks_like_a_cable_counts_fully():
    assert evidence_after(0.0, appearance=ORDINARY_APPEARANCE + 2.0) == pytest.approx(2.0)
    assert evidence_after(4.0, appearance=ORDINARY_APPEARANCE - 5.0) == pytest.approx(
        BACKGROUND_SHARE * 4.0 - 5.0
    )


@pytest.mark.parametrize(("old", "new"), [(5.0, 7.0), (7.0, 5.0), (0.0, 99.0)])
def test_a_new_group_gains_only_the_evidence_beyond_that_of_the_surviving_group(old, new):
    log_prior = np.log([0.9, 0.1])
    ratios = np.array([old, new]) / BACKGROUND_SHARE
    first, second = corrected(log_prior + ratios, log_prior, [1.0, 0.0], [0, 1]) - log_prior
    assert first == pytest.approx(0.15 * min(old, 8.0))
    assert second == pytest.approx(0.15 * old + min(new - old, 8.0))


def test_evidence_that_the_bottom_explains_too_does_not_count():
    assert evidence_after(6.0, background=4.0) == pytest.approx(BACKGROUND_SHARE * 2.0)


def test_evidence_for_thin_strips_counts_less():
    assert evidence_after(4.0, width=3.0) == pytest.approx(BACKGROUND_SHARE * 2.0)
    assert evidence_after(4.0, width=12.0) == pytest.approx(BACKGROUND_SHARE * 4.0)


def test_evidence_counts_up_to_a_limit_that_a_wrong_width_lowers():
    assert evidence_after(100.0) == pytest.approx(8.0)
    assert evidence_after(100.0, penalty=-3.0) == pytest.approx(5.0)


def test_the_evidence_of_a_surviving_group_counts_only_by_the_repeated_share():
    assert evidence_after(6.0, survived=1.0) == pytest.approx(6.0 * BACKGROUND_SHARE * 0.15)
    assert evidence_after(6.0, survived=0.5) == pytest.approx(
        6.0 * BACKGROUND_SHARE * (0.5 * 0.15 + 0.5)
    )


def test_within_a_group_the_likelihood_decides_as_before():
    posterior = np.array([1.0, -1.0, 5.0])
    after = corrected(posterior, np.zeros(3), [0.0] * 3, [0, 0, NO_CLUSTER])
    assert after[0] - after[1] == pytest.approx(2.0)


def test_an_impossible_particle_stays_impossible():
    impossible = np.full(2, -math.inf)
    assert (corrected(impossible, impossible, [1.0] * 2, [0, 0]) == -math.inf).all()


@pytest.mark.parametrize(
    ("survived", "masses", "reference"),
    [
        ([0.9, 0.8, 0.1], [-2.0, -1.0, 0.0], 1),
        ([0.4, 0.1, 0.0], [-2.0, -1.0, 0.0], NO_CLUSTER),
        ([0.9, 0.9, 0.9], [-1.0, -1.0, -math.inf], 0),
    ],
)
def test_the_reference_is_the_heaviest_group_that_survived(survived, masses, reference):
    none = np.zeros(4)
    found = GroupEvidence(none, none, np.array([*survived, 1.0]), none, np.array([*masses, 9.0]))
    assert reference_group(found) == reference


def test_beside_a_known_cable_looks_do_not_count():
    assert evidence_after(2.0, is_known=True, appearance=9.0) == pytest.approx(2.0)
    assert evidence_after(2.0, is_known=True, appearance=-9.0) == pytest.approx(2.0)
    beside_map = evidence_after(CLEAR_MAP + 2.0, is_known=True, mapped=CLEAR_MAP)
    assert beside_map == pytest.approx(2.0)
