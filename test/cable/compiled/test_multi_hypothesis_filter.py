from __future__ import annotations

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.multi_hypothesis_filter import (
    LEAST_PRESENCE,
    MultiHypothesisFilter,
)
from cable_tracker.cable.measure.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.working_image import make_working_image
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.particle_filter.resampling import RESAMPLING_SCHEMES

pytest.importorskip("numba")

from cable_tracker.cable.compiled.likelihood_ratio import CompiledLikelihoodRatio
from cable_tracker.cable.compiled.multi_hypothesis_filter import CompiledMultiHypothesisFilter

SIZE = (160, 120)
FRAME = 0.04
STRIP = CableState(12.0, 0.2, 24.0, 0.03)
ACROSS_THE_WRAP = CableState(5.0, np.pi / 2, 24.0, 0.03)
NONE = np.empty((0, 4))


def twins(seed=0, **changes) -> tuple[MultiHypothesisFilter, CompiledMultiHypothesisFilter]:
    values = TrackerParameters(particle_count=300).replaced(changes)
    plain = BorderLikelihoodRatio(values)
    compiled = CompiledLikelihoodRatio(values)
    return (
        MultiHypothesisFilter(values, plain, SIZE, np.random.default_rng(seed)),
        CompiledMultiHypothesisFilter(values, compiled, SIZE, np.random.default_rng(seed)),
    )


def cloud(state, count=300, seed=0) -> np.ndarray:
    sigma = np.array([2.0, 0.03, 2.0, 0.02, 5.0, 0.05, 2.0, 0.02])
    return state.to_array() + np.random.default_rng(seed).standard_normal((count, 8)) * sigma


def found_near(state) -> np.ndarray:
    return state.to_array()[None, :4] + np.array([[1.0, 0.02, -1.0, 0.0], [-40.0, 0.1, 5.0, 0.0]])


def working(picture, noise) -> object:
    texture = noise.astype(np.float32) - 110.0
    return make_working_image(picture.astype(np.float32) + texture, 320)


@pytest.fixture
def strip(draw_strip, noise_picture):
    def make(state=STRIP, seed=1):
        picture = draw_strip(state, SIZE, strip=130.0, ground=100.0, blur=2.0)
        return working(picture, noise_picture(seed, SIZE, 4.0))

    return make


def assert_alike(plain, compiled, tolerance=1e-5) -> None:
    """All that is believed is the same, to rounding."""
    np.testing.assert_allclose(
        compiled.particles.states, plain.particles.states, rtol=tolerance, atol=tolerance
    )
    np.testing.assert_allclose(
        compiled.particles.weights, plain.particles.weights, atol=10 * tolerance
    )
    assert compiled.presence == pytest.approx(plain.presence, abs=tolerance)
    assert compiled.bright == pytest.approx(plain.bright, abs=tolerance)
    assert compiled.evidence == pytest.approx(plain.evidence, abs=10 * tolerance)
    assert compiled.seen == pytest.approx(plain.seen, abs=10 * tolerance)
    assert len(compiled.clusters) == len(plain.clusters)
    for one, other in zip(compiled.clusters, plain.clusters, strict=True):
        np.testing.assert_array_equal(one.members, other.members)
        assert one.mass == pytest.approx(other.mass, abs=10 * tolerance)
        np.testing.assert_allclose(one.mean, other.mean, atol=100 * tolerance)
    assert (compiled.memory is None) == (plain.memory is None)
    assert (compiled.usual_width is None) == (plain.usual_width is None)


def step_both(belief, image, detections=NONE, dt=FRAME, seed=0, aid=None, **changes):
    plain, compiled = twins(seed, **changes)
    plain.aid_by(aid)
    compiled.aid_by(aid)
    expected = plain.step(belief, image, dt, detections)
    found = compiled.step(belief, image, dt, detections)
    assert_alike(expected, found)
    np.testing.assert_allclose(
        compiled.leading_covariance(found), plain.leading_covariance(expected), atol=1e-2
    )
    assert compiled.effective_sample_size(found) == pytest.approx(
        plain.effective_sample_size(expected), rel=1e-3
    )
    return expected


@pytest.mark.parametrize("cable", [STRIP, ACROSS_THE_WRAP, CableState(79.0, 0.1, 30.0)], ids=str)
@pytest.mark.parametrize("detected", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_a_step_from_a_cable_that_is_known(strip, cable, detected, seed):
    plain, _ = twins()
    belief = plain.belief_given(cloud(cable))
    detections = found_near(cable) if detected else NONE
    for number in range(4):
        belief = step_both(belief, strip(cable, number), detections, seed=seed)


@pytest.mark.parametrize("seed", range(4))
def test_a_step_from_nothing(strip, noise_picture, seed):
    plain, _ = twins(seed)
    first = plain.first_belief()
    step_both(first, strip(), found_near(STRIP), seed=seed)
    step_both(first, make_working_image(noise_picture(seed, SIZE), 320), seed=seed)


KINDS = {
    "gaussian": {"diffusion_degrees_of_freedom": 0.0},
    "heavy": {"diffusion_degrees_of_freedom": 2.0},
    "one round": {"refinement_rounds": 1},
    "no rounds": {"refinement_rounds": 0},
    "no detector": {"detector_share": 0.0},
    "few ancestors": {"ancestor_count": 20},
    "nothing born": {"appearance_rate": 0.0, "search_share": 0.0},
    "always gone": {"disappearance_rate": 100.0, "leaving_rate": 100.0, "appearance_rate": 0.0},
    **{scheme: {"resampling": scheme} for scheme in RESAMPLING_SCHEMES},
    **{f"{count} particles": {"particle_count": count} for count in (1, 2, 8, 900)},
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.filterwarnings("error")
def test_a_step_with_other_parameters(strip, kind):
    plain, _ = twins(**KINDS[kind])
    belief = plain.belief_given(cloud(STRIP))
    for number in range(3):
        belief = step_both(belief, strip(STRIP, number), found_near(STRIP), **KINDS[kind])


@pytest.mark.parametrize("dt", [0.0, 1e-9, 0.5, 4.0])
def test_a_step_over_any_time(strip, dt):
    plain, _ = twins()
    before = plain.step(plain.belief_given(cloud(STRIP)), strip(), FRAME, found_near(STRIP))
    step_both(before, strip(), found_near(STRIP), dt)


class Shift:
    """Odometry that says how far d and alpha move."""

    def moved(self, states):
        moved = states.copy()
        moved[:, :2] += [6.0, 0.05]
        moved[:, 4:] = [150.0, 1.25, 0.0, 0.0]
        return moved

    def sigmas(self):
        return np.tile([1.0, 0.01, 1.0, 0.01], 2)


@pytest.mark.parametrize("cable", [STRIP, ACROSS_THE_WRAP], ids=str)
@pytest.mark.parametrize("seed", range(3))
def test_a_step_with_odometry_moves_both_alike_and_as_it_says(strip, cable, seed):
    plain, _ = twins()
    before = plain.belief_given(cloud(cable))
    image, detections = strip(cable, seed), found_near(cable)
    aided = step_both(before, image, detections, seed=seed, aid=Shift())
    step_both(aided, image, detections, seed=seed, aid=Shift())
    unaided = step_both(before, image, detections, seed=seed)
    assert not np.array_equal(aided.particles.states, unaided.particles.states)


def test_after_odometry_both_move_by_their_own_rates_again(strip):
    before = twins()[0].belief_given(cloud(STRIP))
    for usual, told in zip(twins(), twins(), strict=True):
        told.aid_by(Shift())
        told.aid_by(None)
        expected, found = (each.step(before, strip(), FRAME, NONE) for each in (usual, told))
        np.testing.assert_array_equal(found.particles.states, expected.particles.states)


def test_a_cable_that_was_seen_is_looked_for_alike(strip, noise_picture):
    plain, _ = twins()
    belief = plain.belief_given(cloud(STRIP))
    for number in range(8):
        belief = plain.step(belief, strip(STRIP, number), FRAME, found_near(STRIP))
    assert belief.memory is not None
    assert belief.usual_width is not None
    for number in range(6):
        image = make_working_image(noise_picture(number, SIZE), 320)
        belief = step_both(belief, image, found_near(STRIP), 0.2)
    assert belief.presence < 0.5


def test_a_belief_in_one_particle_alone(strip):
    plain, _ = twins()
    belief = plain.belief_given(np.tile(STRIP.to_array(), (300, 1)))
    step_both(belief, strip(), found_near(STRIP))


def test_what_cannot_be_is_a_new_search_for_both(strip):
    impossible = {
        "width_minimum": 150.0, "initial_width_minimum": 6.0, "initial_width_maximum": 20.0,
        "detector_share": 0.0, "diffusion_degrees_of_freedom": 0.0,
    }  # fmt: skip
    plain, _ = twins(**impossible)
    after = step_both(plain.first_belief(), strip(), **impossible)
    assert after.presence == LEAST_PRESENCE


def test_the_belief_before_and_those_after_are_not_changed(strip):
    _, compiled = twins()
    before = compiled.belief_given(cloud(STRIP))
    after = compiled.step(before, strip(), FRAME, found_near(STRIP))
    beliefs = (before, after)
    copies = [
        (belief.particles.states.copy(), belief.particles.log_weights.copy()) for belief in beliefs
    ]
    compiled.step(after, strip(STRIP, 2), FRAME, found_near(STRIP))
    for belief, (states, weights) in zip(beliefs, copies, strict=True):
        np.testing.assert_array_equal(belief.particles.states, states)
        np.testing.assert_array_equal(belief.particles.log_weights, weights)


EXTREMES = {
    "all detected": {"detector_share": 0.9, "refinement_share": 0.0, "search_share": 0.0},
    "all refined": {"detector_share": 0.0, "refinement_share": 0.9, "search_share": 0.0},
    "all searching": {"detector_share": 0.0, "refinement_share": 0.0, "search_share": 0.9},
    "one place to start": {
        "initial_distance_range": 0.0, "initial_angle_range": 0.0,
        "initial_width_minimum": 30.0, "initial_width_maximum": 30.0,
        "initial_skew_minimum": 0.0, "initial_skew_maximum": 0.0,
    },
    "evidence as it is": {"evidence_repeated": 1.0, "evidence_limit": 1e6, "tempering": 1.0},
    "cauchy": {"diffusion_degrees_of_freedom": 1.0},
    "gaussian": {"diffusion_degrees_of_freedom": 0.0},
    "few": {"particle_count": 2},
}  # fmt: skip


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", EXTREMES)
def test_extreme_parameters_give_a_sound_belief(strip, noise_picture, kind):
    _, compiled = twins(**EXTREMES[kind])
    belief = compiled.first_belief()
    empty = make_working_image(noise_picture(1, SIZE), 320)
    steps = [(strip(), FRAME)] * 3 + [(empty, 3.0), (strip(), 3.0), (empty, 1e-9)]
    for image, dt in steps:
        belief = compiled.step(belief, image, dt, found_near(STRIP))
        assert np.isfinite(belief.particles.states).all()
        assert belief.particles.weights.sum() == pytest.approx(1.0)
        assert 0.0 < belief.presence < 1.0
        assert np.isfinite([belief.evidence, belief.seen, belief.bright]).all()
        assert belief.clusters
