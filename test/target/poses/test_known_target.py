import math
from types import SimpleNamespace

import numpy as np
import pytest

from cable_tracker.target.measure.clutter import UsualScore
from cable_tracker.target.model.births import Births
from cable_tracker.target.poses.known_target import KnownTarget


def pose(log_scale):
    return np.array([3.0, 4.0, log_scale, 0.1, 0.0, 0.0])


@pytest.fixture
def known():
    score = UsualScore(1.0, 0.1)
    births = Births(pose(0.0), 2.0, 10.0, (240, 320))
    looks = SimpleNamespace(size=20.0), SimpleNamespace(bins=SimpleNamespace(shape=(4, 4, 1)))
    return KnownTarget(*looks, score, score, 0.5, births, 20.0)


def test_the_size_follows_the_scale(known):
    assert known.size_at(pose(math.log(2.0))) == pytest.approx(40.0)


def test_the_usual_size_is_the_likeliest_and_the_others_less_so_the_shorter_it_is_away(known):
    states = np.stack((pose(0.5), pose(0.9)))
    away = known.log_size_factor(states, 0.1)
    in_view = known.seen_at(pose(0.5)).log_size_factor(states, 0.1)
    assert away[0] == in_view[0] == 0.0
    assert in_view[1] < away[1] < 0.0


def test_the_usual_size_follows_by_a_share(known):
    assert known.with_size(pose(1.0), 0.1).usual_log_scale == pytest.approx(0.55)


def test_where_it_was_seen_it_may_come_again(known):
    births = known.seen_at(pose(0.2)).births
    assert births.seconds == 0.0
    np.testing.assert_array_equal(births.last, pose(0.2))
