from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from plain_images import plain_image

from cable_tracker.cable.hypotheses import frame_inputs, multi_hypothesis_filter
from cable_tracker.cable.hypotheses.belief import initial_belief
from cable_tracker.cable.hypotheses.cluster_estimates import (
    SMALLEST_HYPOTHESIS,
    displacement_factors,
)
from cable_tracker.cable.hypotheses.multi_hypothesis_filter import (
    GIVEN_PRESENCE,
    MultiHypothesisFilter,
)
from cable_tracker.cable.hypotheses.presence import HIGHEST, LEAST_PRESENCE
from cable_tracker.cable.measure.borders.likelihood_ratio import BorderLikelihoodRatio
from cable_tracker.cable.measure.borders.response_table import load_table
from cable_tracker.cable.measure.map.cable_map import (
    LONGEST_KEPT,
    NO_KEPT_MAP,
    NOTHING_EXPECTED,
    KeptMap,
    MapBorders,
    cable_map_of,
    map_overlap,
    overlap_of_best,
)
from cable_tracker.cable.measure.map.map_strips import map_borders, strip_shares, strips_of_map
from cable_tracker.cable.measure.picture import working_image
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.parameters import TrackerParameters
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.bootstrap_filter import BootstrapFilter, make_observation
from cable_tracker.particle_filter.existence import probability_of

SIZE = (160, 120)
FRAME = 0.04
STRIP = CableState(12.0, 0.2, 24.0, 0.03)
OTHER = CableState(-45.0, -0.15, 20.0, 0.0)
NO_DETECTIONS = np.empty((0, 4))
FOUND = STRIP.to_array()[None, :4] + np.array([1.0, 0.02, -1.0, 0.0])
BOTH_FOUND = np.array([STRIP.to_array()[:4], OTHER.to_array()[:4]])
TOO_FAINT = {"evidence_to_find": 100.0}
"""No strip has so much evidence."""


def parameters(**changes) -> TrackerParameters:
    return TrackerParameters(particle_count=400).replaced(changes)


def make_filter(seed=0, **changes) -> MultiHypothesisFilter:
    values = parameters(**changes)
    rng = np.random.default_rng(seed)
    return MultiHypothesisFilter(values, BorderLikelihoodRatio(values), SIZE, rng)


def cloud(state, count=400, seed=0, wide=1.0) -> np.ndarray:
    sigma = wide * np.array([2.0, 0.03, 2.0, 0.02, 5.0, 0.05, 2.0, 0.02])
    rng = np.random.default_rng(seed)
    return state.to_array() + rng.standard_normal((count, 8)) * sigma


def given(cable_filter):
    return cable_filter.given_belief(cloud(STRIP))


def guessed(cable_filter):
    return cable_filter.given_belief(cloud(STRIP), is_certain=False)


@pytest.fixture
def strip(draw_strip):
    return plain_image(draw_strip(STRIP, SIZE, strip=130.0, ground=100.0, blur=2.0))


@pytest.fixture
def noise(noise_picture):
    return lambda seed: plain_image(noise_picture(seed, SIZE))


def mean_of(belief) -> np.ndarray:
    return belief.hypotheses.clusters.means[0, :4]


def posterior(image, detections, runs=10, **changes) -> tuple[np.ndarray, np.ndarray]:
    """Mean over several seeds of the estimate of one frame, and its standard error, (4,) each."""
    means = []
    for seed in range(runs):
        cable_filter = make_filter(seed, **changes)
        belief = cable_filter.given_belief(cloud(STRIP, seed=seed, wide=1.5))
        means.append(mean_of(cable_filter.step(belief, image, FRAME, detections)))
    values = np.array(means)
    return values.mean(axis=0), values.std(axis=0, ddof=1) / np.sqrt(runs)


BROAD = {"particle_count": 600, "tempering": 0.01, "ancestor_count": 600}
PROPOSALS = {
    name: dict(zip(("detector_share", "search_share", "refinement_share"), shares, strict=True))
    for name, shares in {
        "no proposal": (0.0, 0.05, 0.0),
        "a detector": (0.4, 0.05, 0.0),
        "rounds": (0.0, 0.05, 0.6),
        "a search": (0.0, 0.4, 0.0),
        "all": (0.2, 0.2, 0.4),
    }.items()
}


def test_the_posterior_does_not_depend_on_the_proposals(strip):
    """Wherever particles are drawn, their weights give the posterior of the same prior.

    The detector sees the cable beside its place and the likelihood is weak: if what is proposed
    counted as evidence, the estimate would be drawn there.
    """
    beside = STRIP.to_array()[None, :4] + np.array([3.0, 0.05, 3.0, 0.0])
    results = {
        name: posterior(strip, beside, **BROAD, **changes) for name, changes in PROPOSALS.items()
    }
    reference, reference_error = results.pop("no proposal")
    for name, (mean, error) in results.items():
        tolerance = 4.5 * np.hypot(error, reference_error)
        assert (np.abs(mean - reference) < tolerance).all(), name
        # The shift of the detector is more than what could hide in the tolerance.
        assert (tolerance[:3] < 0.5 * (beside[0, :3] - STRIP.to_array()[:3])).all(), name


def test_the_presence_does_not_depend_on_the_proposals(strip):
    log_odds = {}
    for name, changes in PROPOSALS.items():
        values = []
        for seed in range(8):
            cable_filter = make_filter(seed, **BROAD, **changes)
            belief = initial_belief(cloud(STRIP, seed=seed), 0.5)
            presence = cable_filter.step(belief, strip, FRAME, FOUND).presence
            values.append(np.log(presence / (1.0 - presence)))
        log_odds[name] = np.mean(values)
    assert np.ptp(list(log_odds.values())) < 0.25, log_odds


def run(cable_filter, belief, images, detections=NO_DETECTIONS, dt=FRAME) -> list:
    beliefs = []
    for image in images:
        belief = cable_filter.step(belief, image, dt, detections)
        beliefs.append(belief)
    return beliefs


def assert_sound(belief) -> None:
    assert np.isfinite(belief.particles.states).all()
    assert belief.particles.weights.sum() == pytest.approx(1.0)
    assert LEAST_PRESENCE - 1e-9 <= belief.presence <= probability_of(HIGHEST)
    assert 0.0 < belief.p_bright < 1.0
    masses = belief.hypotheses.clusters.masses
    assert len(masses)
    probabilities = masses / (1.0 + np.exp(-belief.log_odds))
    assert (np.diff(probabilities) <= 0.0).all()
    assert np.isfinite(
        [belief.hypotheses.weaker_border_mean, belief.hypotheses.visible_length]
    ).all()
    angles = belief.particles.states[:, 1]
    assert ((angles > -np.pi / 2) & (angles <= np.pi / 2)).all()


@pytest.mark.parametrize("seed", range(2))
def test_the_presence_rises_on_a_strip_and_the_estimate_settles_there(strip, seed):
    cable_filter = make_filter(seed)
    beliefs = run(cable_filter, cable_filter.first_belief(), [strip] * 15, FOUND)
    assert beliefs[-1].presence > 0.95
    settled = np.mean([mean_of(belief)[[0, 2]] for belief in beliefs[5:]], axis=0)
    np.testing.assert_allclose(settled, [STRIP.distance, STRIP.width], atol=1.5)


@pytest.mark.parametrize("seed", range(2))
def test_the_presence_stays_low_on_noise(noise, seed):
    cable_filter = make_filter(seed)
    images = [noise(100 * seed + k) for k in range(15)]
    beliefs = run(cable_filter, cable_filter.first_belief(), images, FOUND)
    assert max(belief.presence for belief in beliefs) < 0.5


@pytest.mark.parametrize(
    ("strip", "ground", "least", "most"), [(180.0, 80.0, 0.9, 1.0), (80.0, 180.0, 0.0, 0.1)]
)
def test_the_polarity_of_a_cable_becomes_known(draw_strip, strip, ground, least, most):
    image = plain_image(draw_strip(STRIP, SIZE, strip=strip, ground=ground))
    cable_filter = make_filter()
    belief = run(cable_filter, given(cable_filter), [image] * 10)[-1]
    assert least < belief.p_bright < most


def test_two_strips_are_two_hypotheses_and_the_estimate_is_on_one_of_them(draw_strip):
    pictures = [draw_strip(state, SIZE, strip=180.0, ground=80.0) for state in (STRIP, OTHER)]
    image = plain_image(np.maximum(*pictures))
    # The network may take both and what is between them for one wide cable.
    cable_filter = make_filter(looks="borders")
    states = np.concatenate((cloud(STRIP, 200), cloud(OTHER, 200)))
    belief = cable_filter.step(cable_filter.given_belief(states), image, FRAME, BOTH_FOUND)
    assert (belief.hypotheses.clusters.masses > 0.3).sum() == 2
    for after in run(cable_filter, belief, [image] * 10, BOTH_FOUND):
        distance = mean_of(after)[0]
        assert min(abs(distance - 12.0), abs(distance + 45.0)) < 3.0
        assert_sound(after)


def test_the_width_and_the_place_are_remembered_while_a_cable_is_tracked(strip, noise):
    cable_filter = make_filter()
    seen = run(cable_filter, given(cable_filter), [strip] * 15, FOUND)[-1]
    assert np.exp(seen.memory.log_width) == pytest.approx(24.0, abs=2.5)
    assert seen.memory.seconds == 0.0
    np.testing.assert_allclose(seen.memory.pose, STRIP.to_array()[:4], atol=1.5)
    gone = run(cable_filter, seen, [noise(k) for k in range(25)])[-1]
    assert gone.presence < 0.5
    assert gone.memory.seconds > 0.4


def faint_beside_clear(draw_strip, noise_picture) -> list:
    """A faint STRIP, and a clear OTHER that comes into view after eight frames."""
    faint = draw_strip(STRIP, SIZE, strip=124.0, ground=100.0, blur=2.0).astype(float)
    clear = draw_strip(OTHER, SIZE, strip=190.0, ground=100.0).astype(float)
    pictures = [faint] * 8 + [np.maximum(faint, clear)] * 17
    noises = [noise_picture(seed, SIZE).astype(float) - 128.0 for seed in range(len(pictures))]
    shown = zip(pictures, noises, strict=True)
    return [
        plain_image(np.clip(each + 0.2 * noise, 0, 255).astype(np.uint8)) for each, noise in shown
    ]


@pytest.mark.parametrize(("limit", "is_left"), [(4.0, False), (1e6, True)])
def test_a_known_cable_is_not_left_for_a_clearer_strip(draw_strip, noise_picture, limit, is_left):
    images = faint_beside_clear(draw_strip, noise_picture)
    ends = []
    for seed in range(3):
        cable_filter = make_filter(seed, evidence_limit_known=limit)
        belief = given(cable_filter)
        ends.append(mean_of(run(cable_filter, belief, images, BOTH_FOUND)[-1])[0])
    distances = np.array(ends)
    on_other = np.abs(distances - OTHER.distance) < 5.0
    on_strip = np.abs(distances - STRIP.distance) < 5.0
    assert on_other.any() if is_left else on_strip.all(), ends


def test_a_cable_is_known_when_it_was_given_or_followed_for_long(strip, noise):
    cable_filter = make_filter()
    assert run(cable_filter, given(cable_filter), [strip])[-1].is_given
    guess = guessed(cable_filter)
    followed = run(cable_filter, guess, [strip] * 10, FOUND)[-1]
    assert followed.known_time == pytest.approx(10 * FRAME)
    gone = run(cable_filter, followed, [noise(k) for k in range(25)])[-1]
    assert gone.known_time == 0.0
    assert cable_filter.first_belief().known_time == 0.0


def test_a_guessed_cable_too_faint_to_claim_is_neither_known_nor_remembered(strip):
    cable_filter = make_filter(**TOO_FAINT)
    believed = run(cable_filter, guessed(cable_filter), [strip] * 10, FOUND)[-1]
    assert believed.presence > 0.9
    assert believed.known_time == 0.0
    assert believed.memory is None
    assert believed.p_bright == pytest.approx(0.5)


def test_a_given_cable_too_faint_to_claim_is_known_and_remembered(strip):
    cable_filter = make_filter(**TOO_FAINT)
    believed = run(cable_filter, given(cable_filter), [strip] * 10, FOUND)[-1]
    assert believed.is_given
    assert believed.memory is not None


def test_a_new_search_begins_after_too_long_without_a_claim(strip):
    cable_filter = make_filter(**TOO_FAINT, search_time=0.4)
    beliefs = run(cable_filter, guessed(cable_filter), [strip] * 30, FOUND)
    faint_times = np.array([belief.faint_time for belief in beliefs])
    assert 0.4 <= faint_times.max() < 0.4 + 2 * FRAME
    assert (np.diff(faint_times) < 0.0).any()


def test_no_new_search_begins_while_a_given_cable_is_seen(strip):
    cable_filter = make_filter(**TOO_FAINT, search_time=0.4)
    beliefs = run(cable_filter, given(cable_filter), [strip] * 30, FOUND)
    assert not any(belief.faint_time for belief in beliefs)


def test_a_new_search_remembers_the_cable_that_was_tracked(strip):
    cable_filter = make_filter(search_time=0.4)
    tracked = run(cable_filter, given(cable_filter), [strip] * 10, FOUND)[-1]
    too_faint = replace(tracked, faint_time=0.4)
    (anew,) = run(make_filter(**TOO_FAINT, search_time=0.4), too_faint, [strip], FOUND)
    assert anew.faint_time < 0.4
    assert anew.memory.seconds == pytest.approx(tracked.memory.seconds + FRAME)
    assert anew.memory.log_width == tracked.memory.log_width


def test_a_new_search_begins_when_every_particle_is_impossible(strip, monkeypatch):
    # Of what survives, nothing is as wide as it has to be, and there is nothing else.
    monkeypatch.setattr(frame_inputs, "BORDER_SWITCH_SHARE", 0.0)
    cable_filter = make_filter(
        width_minimum=150.0, appearance_rate=0.0, search_share=0.0, detector_share=0.0,
        diffusion_degrees_of_freedom=0.0,
    )  # fmt: skip
    before = guessed(cable_filter)
    (after,) = run(cable_filter, before, [strip])
    assert_sound(after)
    assert after.presence == LEAST_PRESENCE
    assert after.particles.count == 400
    assert not np.array_equal(after.particles.states, before.particles.states)


def test_an_appearance_rate_of_zero_gives_sound_beliefs(strip, noise):
    cable_filter = make_filter(appearance_rate=0.0, evidence_repeated=0.0)
    images = [noise(k) for k in range(6)] + [strip] * 6
    for belief in run(cable_filter, cable_filter.first_belief(), images, FOUND):
        assert_sound(belief)


@pytest.mark.parametrize("count", [1, 3, 900])
def test_another_number_of_particles_keeps_what_is_believed(strip, count):
    cable_filter = make_filter()
    belief = run(cable_filter, given(cable_filter), [strip] * 3)[-1]
    converted = make_filter(particle_count=count).converted(belief)
    assert converted.particles.count == count
    assert converted.presence == belief.presence
    assert converted.memory is belief.memory
    assert len(converted.hypotheses.clusters.labels) == count
    np.testing.assert_allclose(mean_of(converted)[0], mean_of(belief)[0], atol=3.0)


@pytest.mark.parametrize("count", [1, 2, 8, 3000])
@pytest.mark.parametrize("rounds", [0, 4])
def test_any_number_of_particles_runs_without_a_warning(strip, noise, count, rounds):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cable_filter = make_filter(particle_count=count, refinement_rounds=rounds)
        belief = cable_filter.first_belief()
        for image, detections in ((strip, NO_DETECTIONS), (strip, FOUND), (noise(1), FOUND)):
            belief = cable_filter.step(belief, image, FRAME, detections)
            assert_sound(belief)
            assert belief.particles.count == count


EXTREMES = {
    "all detected": {"detector_share": 0.9, "refinement_share": 0.0, "search_share": 0.0},
    "all refined": {"detector_share": 0.0, "refinement_share": 0.9, "search_share": 0.0},
    "all searching": {"detector_share": 0.0, "refinement_share": 0.0, "search_share": 0.9},
    "no movement": dict.fromkeys(
        [f"{name}_variance" for name in ("distance", "angle", "width", "skew")]
        + [f"{name}_rate_variance" for name in ("distance", "angle", "width", "skew")],
        0.0,
    ),
    "no damping": {"rate_damping": 1.0},
    "no rates": {"rate_damping": 0.0},
    "one place to start": {
        "initial_distance_range": 0.0, "initial_angle_range": 0.0,
        "initial_width_minimum": 30.0, "initial_width_maximum": 30.0,
        "initial_skew_minimum": 0.0, "initial_skew_maximum": 0.0,
    },
    "never gone": {"disappearance_rate": 0.0, "leaving_rate": 0.0, "appearance_rate": 100.0},
    "always gone": {"disappearance_rate": 100.0, "leaving_rate": 100.0, "appearance_rate": 0.0},
    "evidence as it is": {
        "evidence_repeated": 1.0,
        "evidence_limit": 1e6,
        "evidence_limit_known": 1e6,
        "tempering": 1.0,
    },
    "no polarity": {"polarity_memory": 0.0},
    "one width": {"width_minimum": 48.0, "width_maximum": 48.0},
    "no skew": {"skew_limit": 0.0},
    "cauchy": {"diffusion_degrees_of_freedom": 1.0},
    "gaussian": {"diffusion_degrees_of_freedom": 0.0},
}  # fmt: skip


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", EXTREMES)
def test_extreme_parameters_run_without_a_warning(strip, noise, kind):
    cable_filter = make_filter(particle_count=150, **EXTREMES[kind])
    belief = cable_filter.first_belief()
    steps = [(strip, FRAME)] * 3 + [(noise(1), 3.0), (strip, 3.0), (noise(2), 1e-9)]
    for image, dt in steps:
        belief = cable_filter.step(belief, image, dt, FOUND)
        assert_sound(belief)


def test_the_belief_before_is_not_changed(strip):
    cable_filter = make_filter()
    belief = given(cable_filter)
    states, weights = belief.particles.states.copy(), belief.particles.log_weights.copy()
    cable_filter.step(belief, strip, FRAME, FOUND)
    np.testing.assert_array_equal(belief.particles.states, states)
    np.testing.assert_array_equal(belief.particles.log_weights, weights)


def test_a_given_cable_that_is_there_is_claimed_with_the_first_frame(strip):
    # The cells of a map are coarse beside a picture of 160 px: w is that of the borders.
    cable_filter = make_filter(map_width_share=0.0)
    belief = cable_filter.step(given(cable_filter), strip, 0.0, NO_DETECTIONS)
    summary = cable_filter.summary(belief, strip)
    assert summary.supports_claim
    assert summary.supports_keeping
    assert summary.presence > 0.9
    state = summary.hypotheses[0].state
    np.testing.assert_allclose([state.distance, state.width], [12.0, 24.0], atol=1.5)


def test_a_flat_picture_neither_rises_nor_holds():
    flat = plain_image(np.full(SIZE[::-1], 90, np.uint8))
    cable_filter = make_filter()
    belief = run(cable_filter, given(cable_filter), [flat] * 11)[-1]
    summary = cable_filter.summary(belief, flat)
    assert not summary.supports_claim
    assert not summary.supports_keeping
    assert summary.presence < GIVEN_PRESENCE - 0.1


def test_hypotheses_are_reported_likeliest_first_and_the_covariance_is_of_one(draw_strip):
    pictures = [draw_strip(state, SIZE) for state in (STRIP, OTHER)]
    image = plain_image(np.maximum(*pictures))
    cable_filter = make_filter(border_displacement=0.0, looks="borders")
    belief = cable_filter.given_belief(np.concatenate((cloud(STRIP, 200), cloud(OTHER, 200))))
    for after in run(cable_filter, belief, [image] * 8, BOTH_FOUND):
        summary = cable_filter.summary(after, image)
        shares = [hypothesis.probability for hypothesis in summary.hypotheses]
        assert shares == sorted(shares, reverse=True)
        assert sum(shares) <= 1.0 + 1e-9
        assert min(shares[1:], default=1.0) >= SMALLEST_HYPOTHESIS
        assert summary.covariance[0, 0] < 9.0


def test_the_covariance_goes_with_the_estimate_across_the_wrap(draw_strip):
    horizontal = CableState(10.0, np.pi / 2, 24.0)
    image = plain_image(draw_strip(horizontal, SIZE))
    cable_filter = make_filter(border_displacement=0.0)
    for belief in run(cable_filter, cable_filter.given_belief(cloud(horizontal)), [image] * 15):
        summary = cable_filter.summary(belief, image)
        state = summary.hypotheses[0].state
        assert -np.pi / 2 < state.angle <= np.pi / 2
        assert state.distance * np.sign(state.angle) == pytest.approx(10.0, abs=1.5)
        np.testing.assert_array_equal(summary.covariance, summary.covariance.T)
        assert np.linalg.eigvalsh(summary.covariance).min() > -1e-9


def test_the_covariance_contains_the_displacement_of_the_borders(strip):
    summaries = []
    for displacement in (0.0, 4.0):
        cable_filter = make_filter(border_displacement=displacement)
        belief = cable_filter.step(given(cable_filter), strip, 0.0, NO_DETECTIONS)
        summaries.append(cable_filter.summary(belief, strip))
    plain, wide = summaries
    added = wide.covariance - plain.covariance
    # A clear border is off by 4 px at the reference width, 2 px here: variances 2 and 8, and 4 of
    # w if the cable is round.
    border_means = belief.hypotheses.leading_mean_borders
    left, right = displacement_factors(border_means, 2.0 * plain.hypotheses[0].state.width) ** 2
    both = (left + right) / 2
    np.testing.assert_allclose(np.diag(added)[[0, 2]], [2.0 * both, 8.0 * both + 4.0])
    np.testing.assert_allclose(added[0, 2], 2.0 * (right - left), atol=1e-12)
    assert wide.hypotheses == plain.hypotheses


def fading(state, grey, ground=100.0) -> np.ndarray:
    """Draw a strip whose right border is no edge: its grey fades to that of the ground."""
    columns, rows = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    x, y = columns - (SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2 - rows
    across = x * np.cos(state.angle) + y * np.sin(state.angle) - state.distance
    left = np.clip(across + state.width / 2 + 0.5, 0.0, 1.0)
    right = np.clip(1.0 - across / state.width, 0.0, 1.0)
    picture = ground + (grey - ground) * left * right
    return picture.round().astype(np.uint8)


@pytest.mark.parametrize("grey", [190.0, 20.0])
@pytest.mark.parametrize("angle", [-1.2, 0.0, np.pi / 2])
def test_the_border_that_is_hidden_is_the_uncertain_one(grey, angle):
    """Whichever way the normal is written, and whether the cable is bright or dark."""
    state = CableState(4.0, angle, 30.0)
    right_is_hidden = plain_image(fading(state, grey))
    # A map does not say which border it is that it disagrees with.
    cable_filter = make_filter(looks="borders")
    belief = run(cable_filter, cable_filter.given_belief(cloud(state)), [right_is_hidden] * 2)[-1]
    summary = cable_filter.summary(belief, right_is_hidden)
    sign = np.sign(np.cos(summary.hypotheses[0].state.angle - state.angle))
    covariance = summary.covariance
    correlation = covariance[0, 2] / np.sqrt(covariance[0, 0] * covariance[2, 2])
    assert sign * correlation > 0.5


def test_the_belief_of_another_filter_is_taken_over_as_a_given_one(strip):
    values = preset("thesis")
    observation = make_observation(values, load_table(""))
    thesis = BootstrapFilter(values, observation, SIZE[0], np.random.default_rng(0))
    cable_filter = make_filter()
    converted = cable_filter.converted(thesis.given_belief(cloud(STRIP, 500)))
    assert converted.particles.count == 400
    assert converted.presence > 0.5
    back = thesis.converted(cable_filter.step(converted, strip, FRAME, NO_DETECTIONS))
    assert back.particles.count == values.particle_count
    assert np.median(back.particles.states[:, 0]) == pytest.approx(12.0, abs=3.0)


KEPT = KeptMap(
    cable_map=cable_map_of(np.zeros((30, 40), np.float32), -78.0, 58.0, 4.0),
    pose=STRIP.to_array()[:4],
    borders=MapBorders(10.0, 0.0, 6.0),
    seconds=0.1,
)
"""Of a picture that showed no cable at all, a tenth of a second ago."""


def belief_before(*, state=STRIP, is_given=True, evidence=2.0, kept_map=KEPT):
    belief = initial_belief(cloud(state), GIVEN_PRESENCE)
    hypotheses = belief.hypotheses._replace(weaker_border_mean=evidence)
    return replace(belief, is_given=is_given, hypotheses=hypotheses, kept_map=kept_map)


@pytest.mark.parametrize(
    "before",
    [
        belief_before(is_given=False),
        belief_before(evidence=0.1),
        belief_before(kept_map=NO_KEPT_MAP),
        belief_before(kept_map=replace(KEPT, seconds=parameters().map_interval - FRAME)),
    ],
    ids=["no cable known", "known but faint", "no map yet", "the last map is old"],
)
def test_the_network_looks_at_a_frame_where_it_is_worth_its_time(strip, before):
    after = make_filter().step(before, strip, FRAME, NO_DETECTIONS)
    assert after.hypotheses.is_mapped
    assert after.kept_map.cable_map is strip.cable_map
    assert after.kept_map.seconds == 0.0
    np.testing.assert_array_equal(after.kept_map.pose, mean_of(after))


def borders_by_the_map(belief, strip):
    return map_borders(
        belief.hypotheses.clusters.means[0], strip.cable_map, strip.pixels, strip.reduction
    )


def test_the_borders_of_the_first_map_are_taken_and_those_of_later_ones_averaged(strip):
    first = make_filter().step(belief_before(kept_map=NO_KEPT_MAP), strip, FRAME, NO_DETECTIONS)
    assert first.kept_map.borders == borders_by_the_map(first, strip)
    later = make_filter().step(belief_before(evidence=0.1), strip, FRAME, NO_DETECTIONS)
    kept = replace(KEPT, seconds=KEPT.seconds + FRAME)
    assert later.kept_map.borders == kept.smoothed(borders_by_the_map(later, strip))


def test_without_a_map_of_the_frame_the_borders_stay_where_those_before_showed_them(strip):
    after = make_filter().step(belief_before(), strip, FRAME, NO_DETECTIONS)
    assert after.kept_map.borders == KEPT.borders


def test_a_clear_cable_that_is_known_is_judged_by_the_last_map(strip, monkeypatch):
    monkeypatch.setattr(working_image, "make_cable_map", None)
    after = make_filter().step(belief_before(), strip, FRAME, NO_DETECTIONS)
    assert after.hypotheses.is_mapped
    assert after.kept_map.cable_map is KEPT.cable_map
    assert after.kept_map.seconds == pytest.approx(0.1 + FRAME)
    shown = replace(KEPT, cable_map=strip_map(STRIP))
    alike = (
        make_filter()
        .step(belief_before(kept_map=shown), strip, FRAME, NO_DETECTIONS)
        .hypotheses.appearance
    )
    assert alike > after.hypotheses.appearance + 3.0


def test_a_known_cable_that_is_not_where_it_was_expected_is_looked_at(strip):
    """The kept map would go along, also to a shadow beside the cable."""
    aside = belief_before(state=replace(STRIP, distance=STRIP.distance - 5.0))
    after = make_filter().step(aside, strip, FRAME, NO_DETECTIONS)
    assert mean_of(after)[0] == pytest.approx(STRIP.distance, abs=2.0)
    assert after.kept_map.cable_map is strip.cable_map
    assert after.kept_map.seconds == 0.0


def strip_map(state):
    return cable_map_of(strip_shares(state.to_array(), KEPT.cable_map), -78.0, 58.0, 4.0)


@pytest.mark.parametrize("is_given", [True, False], ids=["known", "searched for"])
def test_strips_are_held_against_the_expected_one_beside_a_known_cable_else_against_the_best(
    strip, monkeypatch, is_given
):
    frames, conclude = [], multi_hypothesis_filter.draw_and_conclude

    def draw_and_conclude(sample, inputs, config):
        frames.append((inputs.expected_overlap, inputs.prior.expected[0]))
        return conclude(sample, inputs, config)

    monkeypatch.setattr(multi_hypothesis_filter, "draw_and_conclude", draw_and_conclude)
    before = belief_before(is_given=is_given, kept_map=NO_KEPT_MAP)
    make_filter().step(before, strip, FRAME, NO_DETECTIONS)
    ((against, expected),) = frames
    shown = strip.cable_map
    best = overlap_of_best(shown, strips_of_map(shown, 1))
    assert against == ((np.inf, map_overlap(expected, shown)) if is_given else best)
    assert best != NOTHING_EXPECTED


def test_a_map_is_kept_no_longer_than_the_interval(strip):
    cable_filter = make_filter(map_interval=0.2)
    belief, ages = belief_before(kept_map=NO_KEPT_MAP), []
    for _ in range(11):
        belief = cable_filter.step(belief, strip, FRAME, NO_DETECTIONS)
        ages.append(round(belief.kept_map.seconds / FRAME))
    assert ages == [0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0]


def test_without_an_interval_the_network_looks_at_each_frame(strip):
    cable_filter = make_filter(map_interval=0.0)
    for belief in run(cable_filter, belief_before(), [strip] * 3):
        assert belief.kept_map.seconds == 0.0


def test_by_borders_alone_no_map_is_looked_at(strip, monkeypatch):
    monkeypatch.setattr(working_image, "make_cable_map", None)
    before = belief_before(is_given=False, kept_map=NO_KEPT_MAP)
    after = make_filter(looks="borders").step(before, strip, FRAME, NO_DETECTIONS)
    assert not after.hypotheses.is_mapped
    assert after.kept_map.seconds == np.inf


@pytest.mark.parametrize("changes", [{"map_interval": 3600.0}, {"looks": "borders"}])
def test_a_known_cable_is_judged_by_borders_alone_once_its_last_map_is_too_old(strip, changes):
    cable_filter = make_filter(**changes)
    before = belief_before(kept_map=replace(KEPT, seconds=LONGEST_KEPT - 1.5 * FRAME))
    mapped = [belief.hypotheses.is_mapped for belief in run(cable_filter, before, [strip] * 3)]
    assert mapped == [True, False, False]


def density_about_the_strip(strip, turned, monkeypatch) -> float:
    """Return the median proposal density of particles at the strip, seen from a turned belief."""
    samples = []
    draw = multi_hypothesis_filter.draw_and_conclude

    def spy(sample, *others):
        conclusion = draw(sample, *others)
        samples.append((sample, conclusion.states))
        return conclusion

    monkeypatch.setattr(multi_hypothesis_filter, "draw_and_conclude", spy)
    monkeypatch.setattr(working_image, "make_cable_map", lambda *_: strip_map(STRIP))
    elsewhere = CableState(0.0, STRIP.angle - turned, 30.0, 0.0)
    cable_filter = make_filter(refinement_rounds=1)
    guess = cable_filter.given_belief(cloud(elsewhere), is_certain=False)
    cable_filter.step(guess, strip, FRAME, NO_DETECTIONS)
    sample, states = samples[0]
    offsets = np.abs(states[:, :4] - STRIP.to_array()[:4])
    at_strip = (offsets < np.array([6.0, 0.1, 6.0, 0.1])).all(axis=1)
    assert at_strip.sum() > 20
    return float(np.median(sample.proposal_density[: len(states)][at_strip]))


def test_strips_of_the_map_are_drawn_about_in_the_chart_of_the_particles(strip, monkeypatch):
    """Else what is drawn there would lack its own density, and weigh far too much."""
    near = density_about_the_strip(strip, 1.3, monkeypatch)
    beyond = density_about_the_strip(strip, 1.65, monkeypatch)
    assert 0.1 < beyond / near < 10.0
