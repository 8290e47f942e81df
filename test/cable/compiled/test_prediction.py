from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.hypotheses.clusters import SMALLEST_MASS
from cable_tracker.cable.hypotheses.leaving import survival_probabilities, survival_rates
from cable_tracker.cable.hypotheses.multi_hypothesis_filter import (
    LEAST_SURVIVING,
    SMALLEST_CLUSTER_SHARE,
)
from cable_tracker.cable.model.geometry import unwrap_states
from cable_tracker.cable.model.movement import CableMovement, rate_damping_over
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.resampling import systematic_resampling

pytest.importorskip("numba")

from cable_tracker.cable.compiled.clusters import NONE
from cable_tracker.cable.compiled.prediction import Step, ancestor_groups, survivors_of

SEEDS = st.integers(0, 2**32 - 1)
PARAMETERS = TrackerParameters()


class Told:
    """A generator that draws what it was told."""

    def __init__(self, offset: float) -> None:
        self.offset = offset

    def random(self) -> float:
        return self.offset


def any_belief(rng, count, clusters) -> tuple[np.ndarray, np.ndarray]:
    """Members of clusters, (K, N), and log-weights, (N,); some particles are of no cluster."""
    labels = rng.integers(-1, clusters, count)
    members = np.array([labels == cluster for cluster in range(clusters)])
    weights = rng.dirichlet(np.full(count, 0.3)) * (rng.random(count) < 0.8)
    weights[0] += 1e-3
    with np.errstate(divide="ignore"):
        return members, np.log(weights / weights.sum())


def step_over(dt, reference_angle, size) -> Step:
    return Step(
        reference_angle=reference_angle,
        size=(float(size[0]), float(size[1])),
        rates=survival_rates(PARAMETERS, size[0]),
        dt=dt,
        effective_time=CableMovement(PARAMETERS, size[0]).effective_time(dt),
        damping=rate_damping_over(PARAMETERS, dt),
    )


@given(SEEDS, st.integers(4, 80), st.integers(1, 4), st.integers(1, 200))
def test_clusters_and_what_is_in_none_share_the_ancestors(seed, count, clusters, wanted):
    members, log_weights = any_belief(np.random.default_rng(seed), count, clusters)
    weights = np.exp(log_weights)
    everybody = [*members, ~members.any(axis=0)]
    masses = np.array([weights[group].sum() for group in everybody])
    kept = np.flatnonzero(masses > SMALLEST_MASS)
    found = ancestor_groups(members, log_weights, wanted)
    np.testing.assert_allclose(found.weights, weights)
    np.testing.assert_allclose(found.masses, masses[kept])
    for number, group in enumerate(kept):
        np.testing.assert_array_equal(found.labels == number, everybody[group])
    assert ((found.labels == NONE).sum()) == count - sum(everybody[g].sum() for g in kept)
    shares = np.maximum(masses[kept], SMALLEST_CLUSTER_SHARE)
    expected = np.maximum(np.rint(shares / shares.sum() * wanted), 1)
    np.testing.assert_array_equal(found.counts, expected)


@given(
    SEEDS, st.integers(4, 80), st.integers(1, 4), st.floats(0.0, 3.0),
    st.sampled_from([(320, 240), (640, 100)]), st.booleans(),
)  # fmt: skip
def test_ancestors_are_chosen_drift_and_survive_alike_also_far_outside(
    seed, count, clusters, dt, size, outside
):
    rng = np.random.default_rng(seed)
    members, log_weights = any_belief(rng, count, clusters)
    states = rng.uniform(-1, 1, (count, 8)) * np.array([1e5 if outside else 300.0, 3, *[1] * 6])
    groups = ancestor_groups(members, log_weights, 50)
    offsets, reference = rng.random(len(groups.counts)), float(rng.uniform(-1.5, 1.5))
    chosen = []
    for number, (mass, drawn) in enumerate(zip(groups.masses, groups.counts, strict=True)):
        rows = np.flatnonzero(groups.labels == number)
        shares = groups.weights[rows] / mass
        chosen.append(rows[systematic_resampling(shares, int(drawn), Told(offsets[number]))])
    ancestors = unwrap_states(states[np.concatenate(chosen)], reference)
    target = np.repeat(groups.masses / groups.counts, groups.counts)
    survival = survival_probabilities(ancestors, size, PARAMETERS, dt)
    surviving = np.maximum(target / target.sum() * survival, LEAST_SURVIVING)
    drifted = CableMovement(PARAMETERS, size[0]).drift(ancestors, dt)

    places, rates, weights, total = survivors_of(
        states, groups, offsets, step_over(dt, reference, size)
    )
    np.testing.assert_allclose(places, drifted[:, :4], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(rates, drifted[:, 4:], rtol=1e-12, atol=1e-12)
    # How near the edge a cable is hangs on its angle, whose rounding its distance magnifies.
    np.testing.assert_allclose(weights, surviving / surviving.sum(), rtol=1e-9)
    assert total == pytest.approx(surviving.sum(), rel=1e-9)


@given(SEEDS, st.integers(4, 80))
def test_what_weighs_nothing_has_no_children(seed, count):
    rng = np.random.default_rng(seed)
    members, log_weights = any_belief(rng, count, 3)
    states = np.zeros((count, 8))
    # The distance says who the parent was.
    states[:, 0] = np.arange(count)
    groups = ancestor_groups(members, log_weights, 60)
    offsets = rng.random(len(groups.counts))
    places, *_ = survivors_of(states, groups, offsets, step_over(0.04, 0.0, (320, 240)))
    parents = places[:, 0].astype(int)
    assert len(parents) == groups.counts.sum()
    assert np.isfinite(log_weights[parents]).all()
