import numpy as np
import pytest

from cable_tracker.target.poses.known_target import UsualScore
from cable_tracker.target.poses.presence import clutter_of, log_ratio_of_likeness

USUAL = UsualScore(4.0, 0.2)


def test_the_usual_score_speaks_for_the_target_and_that_of_clutter_against_it():
    clutter = clutter_of(np.random.default_rng(1).normal(0.0, 0.5, 500), 0.02)
    for_it, against = clutter.log_ratios(np.array([4.0, 0.0]), USUAL, 0.15)
    assert for_it > 2.0
    assert against < -5.0


def test_a_better_score_than_usual_is_as_good_as_the_usual():
    clutter = clutter_of(np.zeros(50), 0.02)
    usual, better = clutter.log_ratios(np.array([4.0, 5.0]), USUAL, 0.15)
    assert better == pytest.approx(usual, abs=0.1)


def test_restless_clutter_says_less():
    calm, restless = (
        clutter_of(np.random.default_rng(1).normal(1.0, spread, 500), 0.02) for spread in (0.3, 3.0)
    )
    score = np.array([4.0])
    assert calm.log_ratios(score, USUAL, 0.15) > restless.log_ratios(score, USUAL, 0.15)


def test_other_colours_speak_against_the_target():
    usual = UsualScore(0.9, 0.001)
    assert log_ratio_of_likeness(0.9, usual, 0.15) > 0.0 > log_ratio_of_likeness(0.4, usual, 0.15)


def test_the_usual_score_follows_what_is_seen():
    seen = USUAL
    for _ in range(200):
        seen = seen.updated(2.0, 0.05)
    assert seen.mean == pytest.approx(2.0, abs=0.01)
    assert seen.variance < 0.1
