import numpy as np
import pytest

from cable_tracker.contour.shape_prior import log_odds, signed_distances


def test_distances_are_those_to_the_nearest_pixel_on_the_other_side():
    mask = np.random.default_rng(1).random((9, 11)) < 0.4
    places = np.argwhere(np.ones_like(mask))
    padded = {side: np.argwhere(np.pad(mask, 1) == side) - 1 for side in (True, False)}
    for place, signed in zip(places, signed_distances(mask).ravel(), strict=True):
        inside = mask[tuple(place)]
        nearest = np.hypot(*(padded[not inside] - place).T).min()
        assert signed == pytest.approx(0.5 - nearest if inside else nearest - 0.5, abs=1e-4)


def test_odds_are_even_at_the_outline_and_limited_far_from_it():
    mask = np.zeros((30, 30), bool)
    mask[10:20, 10:20] = True
    odds = log_odds(mask, softness=2.0, limit=2.0)
    assert odds[15, 10] == pytest.approx(0.25)
    assert odds[15, 9] == pytest.approx(-0.25)
    assert odds[15, 15] == odds.max() == 2.0
    assert odds[0, 0] == odds.min() == -2.0


def test_an_empty_mask_is_far_from_everything():
    assert (log_odds(np.zeros((5, 5), bool), 1.0, 3.0) == -3.0).all()
