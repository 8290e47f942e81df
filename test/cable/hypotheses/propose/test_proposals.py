from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from cable_tracker.cable.hypotheses.propose.frame_inputs import frame_config
from cable_tracker.cable.hypotheses.propose.proposals import MOST_CANDIDATES, likeliest_strips
from cable_tracker.cable.parameters.parameters import TrackerParameters

CONFIG = frame_config(TrackerParameters(), 4.0, (320, 240))
NOTHING = np.empty((0, 4))
CABLE, ELSEWHERE = [40.0, 0.0, 40.0, 0.0], [-80.0, 0.3, 30.0, 0.0]


@pytest.fixture
def candidates(frame_inputs):
    """Return the candidates (C, 4) among poses of some log-likelihoods and strips of a map."""

    def find(picture, poses, log_likelihoods, shown=NOTHING) -> np.ndarray:
        states = np.hstack((np.array(poses), np.zeros((len(poses), 4))))
        map_strips = np.hstack((shown, np.zeros((len(shown), 4))))
        births = SimpleNamespace(map_strips=map_strips)
        inputs = frame_inputs(picture)._replace(predicted=SimpleNamespace(births=births))
        found = likeliest_strips(states, np.array(log_likelihoods), inputs, CONFIG)
        return found[:, :4]

    return find


def picture_of_a_cable(rng) -> np.ndarray:
    picture = rng.normal(100.0, 10.0, (240, 320))
    picture[:, 180:220] = rng.normal(115.0, 2.0, (240, 40))
    return picture


def test_what_looks_like_a_cable_comes_first_whatever_its_likelihood(candidates, rng):
    found = candidates(picture_of_a_cable(rng), [ELSEWHERE, CABLE], [30.0, 1.0])
    np.testing.assert_array_equal(found, [CABLE, ELSEWHERE])


def test_of_strips_that_lie_together_the_likeliest_is_looked_at(candidates, rng):
    beside = [CABLE[0] + 2.0, *CABLE[1:]]
    found = candidates(picture_of_a_cable(rng), [beside, CABLE, beside], [1.0, 2.0, 0.0])
    np.testing.assert_array_equal(found, [CABLE])


def test_impossible_ones_are_no_candidates(candidates, rng):
    picture = picture_of_a_cable(rng)
    assert len(candidates(picture, [CABLE, ELSEWHERE], [-np.inf, -np.inf])) == 0
    np.testing.assert_array_equal(
        candidates(picture, [CABLE, ELSEWHERE], [-np.inf, 0.0]), [ELSEWHERE]
    )


def test_what_a_map_shows_is_looked_at_though_no_particle_is_there(candidates, rng):
    found = candidates(picture_of_a_cable(rng), [ELSEWHERE], [30.0], np.array([CABLE]))
    np.testing.assert_array_equal(found, [CABLE, ELSEWHERE])


def test_their_number_is_limited(candidates, rng):
    poses = [[20.0 * index - 100.0, 0.4 * (index % 3), 20.0, 0.0] for index in range(10)]
    assert len(candidates(picture_of_a_cable(rng), poses, range(10))) == MOST_CANDIDATES
