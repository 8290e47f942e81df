from __future__ import annotations

import numpy as np
import pytest
from plain_images import plain_image

from cable_tracker.cable.measure.borders.response_table import load_table
from cable_tracker.cable.model.state import CableState
from cable_tracker.cable.parameters.presets import preset
from cable_tracker.cable.thesis.bootstrap_filter import BootstrapFilter, make_observation

SIZE = (160, 120)
FRAME = 0.04
STRIP = CableState(12.0, 0.2, 24.0, 0.03)
NO_DETECTIONS = np.empty((0, 4))


def make_filter(**changes) -> BootstrapFilter:
    parameters = preset("thesis").replaced(changes)
    observation = make_observation(parameters, load_table(""))
    return BootstrapFilter(parameters, observation, SIZE[0], np.random.default_rng(3))


def cloud(state=STRIP, count=500) -> np.ndarray:
    sigma = np.array([3.0, 0.04, 3.0, 0.02, 5.0, 0.05, 0.0, 0.0])
    return state.to_array() + np.random.default_rng(0).standard_normal((count, 8)) * sigma


@pytest.fixture
def strip(draw_strip):
    return plain_image(draw_strip(STRIP, SIZE), sample_spacing=20.0)


@pytest.mark.parametrize("observation", ["responses", "likelihood_ratio"])
def test_a_given_cable_is_followed_as_the_only_hypothesis(strip, observation):
    cable_filter = make_filter(observation=observation)
    belief = cable_filter.given_belief(cloud())
    for _ in range(5):
        belief = cable_filter.step(belief, strip, FRAME, NO_DETECTIONS)
        summary = cable_filter.summary(belief, strip)
        assert abs(summary.hypotheses[0].state.distance - 12.0) < 8.0
    assert summary.presence is None
    assert summary.hypotheses[0].probability == 1.0
    assert 1.0 <= summary.effective_sample_size <= 500.0


def test_the_true_cable_is_claimed_and_none_is_on_a_flat_picture(strip):
    cable_filter = make_filter()
    exact = cable_filter.given_belief(np.tile(STRIP.to_array(), (500, 1)))
    assert cable_filter.summary(exact, strip).supports_claim
    flat = plain_image(np.full(SIZE[::-1], 90, np.uint8))
    summary = cable_filter.summary(cable_filter.step(exact, flat, 0.0, NO_DETECTIONS), flat)
    assert not summary.supports_claim
    assert not summary.supports_keeping
    assert summary.evidence == 0.0


def test_a_belief_about_this_very_frame_does_not_move(strip):
    cable_filter = make_filter()
    before = cable_filter.given_belief(cloud())
    after = cable_filter.step(before, strip, 0.0, NO_DETECTIONS)
    np.testing.assert_array_equal(after.particles.states, before.particles.states)
    later = cable_filter.step(before, strip, FRAME, NO_DETECTIONS)
    assert not np.array_equal(later.particles.states, before.particles.states)


def test_equal_weights_are_not_resampled_and_unequal_ones_are(strip):
    cable_filter = make_filter()
    belief = cable_filter.given_belief(cloud())
    wide = cable_filter.step(belief, strip, 0.0, NO_DETECTIONS)
    resampled = cable_filter.step(wide, strip, 0.0, NO_DETECTIONS).particles.states
    kept = set(map(tuple, belief.particles.states))
    assert set(map(tuple, resampled)) <= kept


def test_another_number_of_particles_is_drawn_from_the_present_ones():
    cable_filter = make_filter(particle_count=70)
    belief = cable_filter.given_belief(cloud())
    converted = cable_filter.converted(belief)
    assert converted.particles.count == 70
    assert set(map(tuple, converted.particles.states)) <= set(map(tuple, belief.particles.states))
    assert cable_filter.converted(converted).particles is converted.particles


def test_only_what_was_given_is_known_to_be_so_until_a_search_begins(strip):
    cable_filter = make_filter()
    given = cable_filter.given_belief(cloud())
    guessed = cable_filter.given_belief(cloud(), is_certain=False)
    for belief, is_given in ((given, True), (guessed, False), (cable_filter.first_belief(), False)):
        after = cable_filter.converted(cable_filter.step(belief, strip, FRAME, NO_DETECTIONS))
        assert cable_filter.summary(after, strip).follows_given == is_given
