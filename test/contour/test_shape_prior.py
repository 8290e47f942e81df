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
    odds = log_odds(signed_distances(mask), softness=2.0, limit=2.0)
    assert odds[15, 10] == pytest.approx(0.25)
    assert odds[15, 9] == pytest.approx(-0.25)
    assert odds[15, 15] == odds.max() == 2.0
    assert odds[0, 0] == odds.min() == -2.0


def test_an_empty_mask_is_far_from_everything():
    assert (log_odds(signed_distances(np.zeros((5, 5), bool)), 1.0, 3.0) == -3.0).all()


def test_equal_masks_have_equal_distances_wherever_they_lie_in_memory():
    rng = np.random.default_rng(3)
    rows, columns = np.mgrid[:61, :75]
    mask = (rows - 30) ** 2 / 18**2 + (columns - 37) ** 2 / 24**2 < 1
    mask[20] = rng.random(75) < 0.5
    expected = signed_distances(mask)
    for size in rng.integers(1, 5000, 40):
        moved = np.zeros(size + mask.size, bool)[size:].reshape(mask.shape)
        moved[...] = mask
        np.testing.assert_array_equal(signed_distances(moved), expected)
